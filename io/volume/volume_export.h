// Volumes for other programs. Lengths are millimetres everywhere, values cell-centred, x fastest;
// voxel (i, j, k) covers [i h, (i+1) h] x [j h, (j+1) h] x [k h, (k+1) h].
//
// Renderers take extinction and albedo instead of κ and μ. By similarity theory with an isotropic
// phase function, σt' = 1/(3κ) and albedo = σs'/σt' = 1 − 3κμ. Where 3κμ ≥ 1 no scattering is left
// and the albedo is set to 0; the result says in how many voxels.
//
// All validate the set first and throw InputError naming file and reason.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/volume/volume_set.h"

namespace kappamu::io {

struct ExportResult {
  std::vector<std::filesystem::path> files;  ///< what was written
  std::vector<std::string> warnings;         ///< one sentence each
};

/// VTK image data: CellData arrays kappa_R [mm], mu_R [1/mm], what is known of their certainty,
/// sigma_t_R [1/mm], albedo_R; float32, raw appended, 64-bit sizes; units, eta and provenance as
/// FieldData.
ExportResult export_vti(const std::filesystem::path& file, const VolumeSet& set);
/// Any volumes of one grid, one or more, without validation.
void export_vti(const std::filesystem::path& file, const std::vector<NamedVolume>& volumes);

/// Mitsuba 3: grid volumes sigma_t.vol and albedo.vol (format version 3; one channel, or R, G, B in
/// one file), for several channels also sigma_t_<channel>.vol and albedo_<channel>.vol, and
/// scene.xml, which renders the block (scene unit mm) with them.
ExportResult export_mitsuba(const std::filesystem::path& folder, const VolumeSet& set);

/// pbrt-v4: the named medium "block" of type rgbgrid, as text (scene unit mm). One channel is grey.
ExportResult export_pbrt(const std::filesystem::path& file, const VolumeSet& set);

/// NumPy arrays and volume.json (io/volume/volume_file.h).
ExportResult export_npy(const std::filesystem::path& folder, const VolumeSet& set);

/// One EXR image per z layer, slice_000.exr from z-, with channels kappa.R, mu.R, ...
ExportResult export_slices(const std::filesystem::path& folder, const VolumeSet& set);

/// OpenVDB (io/volume/volume_file.h).
ExportResult export_vdb(const std::filesystem::path& file, const VolumeSet& set);

}  // namespace kappamu::io
