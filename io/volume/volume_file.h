// Volumes on disk: OpenVDB, the native form, and a folder of NumPy arrays.
//
// OpenVDB: one float grid per quantity and channel, of class fog volume: kappa_R [mm], mu_R [1/mm],
// std_kappa_R [mm], std_mu_R [1/mm], resolution_kappa_R, resolution_mu_R, sensitivity_R where
// known, and derived sigma_t_R [1/mm], albedo_R, and `density` (the channels' mean sigma_t, so that
// a default shader shows something). World coordinates are the sample frame's millimetres: voxel
// index (i, j, k) lies at its centre,
// ((i+1/2) h, (j+1/2) h, (k+1/2) h). Every voxel of the block is active. Numbers are stored as
// 32-bit floats.
//
// Folder: volume.json (voxel size, channels, units, provenance) and kappa_R.npy, mu_R.npy, ...,
// float32 [z][y][x].
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/volume/volume_set.h"

namespace kappamu::io {

/// Numbers that a file of unknown origin may hold in all volumes together: 800 MB in memory. A file
/// of a few kilobytes can claim any number of them (tiles of OpenVDB, holes on the disk).
constexpr std::size_t default_most_voxels = 100'000'000;

/// Throws InputError naming the file when `volumes` of that shape hold more than `most_voxels`.
void check_voxels(const std::filesystem::path& file, const GridShape& shape, std::size_t volumes,
                  std::size_t most_voxels);

/// Validates, then writes.
void write_vdb(const std::filesystem::path& file, const VolumeSet& set);

/// Any volumes of one grid, one or more, without validation: a float grid each, placed as above.
void write_vdb(const std::filesystem::path& file, const std::vector<NamedVolume>& volumes);

/// Reads what the first writes, and any file with pairs of float grids kappa_<channel> and
/// mu_<channel>, or one pair kappa and mu (channel "grey"), on one uniformly scaled grid in mm.
/// Throws InputError naming file and grid otherwise, and before it makes room for more than
/// `most_voxels`; what it returns passes validate().
VolumeSet read_vdb(const std::filesystem::path& file,
                   std::size_t most_voxels = default_most_voxels);

/// Validates, then writes; volume.json comes last, so a folder that has one is complete.
void write_volume_folder(const std::filesystem::path& folder, const VolumeSet& set);
VolumeSet read_volume_folder(const std::filesystem::path& folder,
                             std::size_t most_voxels = default_most_voxels);

/// volume.json as text: format, version, grid, voxel size, eta, channels, units, axis order,
/// provenance.
std::string volume_json(const VolumeSet& set);

/// A .vdb file or a folder with volume.json.
VolumeSet read_volume(const std::filesystem::path& path,
                      std::size_t most_voxels = default_most_voxels);

/// The volume that `path` means: a .vdb file, a folder with volume.json, or a run or fit folder
/// that has volume.vdb or fit/volume.vdb, or fit/volume.json. Throws InputError when there is none.
std::filesystem::path find_volume(const std::filesystem::path& path);
/// The one to look at: where a folder of arrays has a coarser volume beside, because it is too
/// large for one machine, that one: `coarse` in it.
std::filesystem::path find_shown_volume(const std::filesystem::path& path);

}  // namespace kappamu::io
