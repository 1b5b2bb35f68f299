// What `kappamu forward` reads: κ, μ and light from .npy or .vdb files, checked against each
// other.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/grid.h"
#include "io/volume/volume_file.h"

namespace kappamu::app {

struct ForwardFiles {
  std::string kappa;                   ///< .npy [z][y][x], or .vdb
  std::string mu;                      ///< the same
  std::string irradiance;              ///< .npy [M][v][u], or [v][u] for one pattern; empty: none
  std::optional<double> voxel;         ///< [mm]; a .vdb brings its own
  std::optional<std::string> channel;  ///< which of a .vdb's
  std::size_t most_voxels = io::default_most_voxels;  ///< of one file's volumes together
};

/// Throws InputError naming file and voxel of the first bad coefficient, and both files where
/// shapes or voxel sizes disagree.
Medium read_medium(const ForwardFiles& files);

struct Irradiance {
  int patterns = 0;
  std::vector<double> values;  ///< [M][v][u]
};
/// Throws InputError naming the file unless its shape is that of the lit face and every irradiance
/// finite and not negative. No patterns where there is no file.
Irradiance read_irradiance(const ForwardFiles& files, const GridShape& grid, Face lit_face);

}  // namespace kappamu::app
