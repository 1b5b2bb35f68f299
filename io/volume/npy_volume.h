// One volume as a NumPy array [z][y][x], float32.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>

#include "core/grid.h"

namespace kappamu::io {

/// Throws InputError naming file and both shapes unless the array is of `shape`.
Volume<double> read_npy_volume(const std::filesystem::path& file, const GridShape& shape);

/// Of whatever shape, with voxels of `voxel_mm`. Throws InputError unless it has three axes and at
/// most `most_voxels`.
Volume<double> read_npy_volume(const std::filesystem::path& file, double voxel_mm,
                               std::size_t most_voxels = std::numeric_limits<std::size_t>::max());

void write_npy_volume(const std::filesystem::path& file, const Volume<double>& volume);

}  // namespace kappamu::io
