// Volumes into the formats of other programs: what `kappamu export` and the export stage of
// `kappamu run` share.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/progress.h"
#include "io/volume/volume_export.h"

namespace kappamu::pipeline {

/// "vti", "vol", "pbrt", "npy", "vdb", "exr".
const std::vector<std::string>& export_formats();

/// Writes `volume` (see io::find_volume) into `folder` as each of `formats` ("all" for every one):
/// volume.vti, volume.vdb, medium.pbrt, and the folders mitsuba, npy and exr. Warnings go to
/// `progress` and into the result. Throws InputError when the volume has a NaN, a non-positive κ or
/// more than `most_voxels` numbers, and when a format is unknown.
io::ExportResult export_volumes(const std::filesystem::path& volume,
                                const std::filesystem::path& folder,
                                const std::vector<std::string>& formats, Progress& progress,
                                std::size_t most_voxels);

}  // namespace kappamu::pipeline
