// What `kappamu forward` reads: κ, μ, light and masks from .npy or .vdb files, checked against each
// other.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/grid.h"
#include "io/volume/volume_file.h"

namespace kappamu::app {

struct ForwardFiles {
  std::string kappa;                                  ///< .npy [z][y][x], or .vdb
  std::string mu;                                     ///< the same
  std::string irradiance;                             ///< .npy [M][v][u], or [v][u] for one pattern
  std::optional<std::string> light_mask;              ///< .npy [v][u] or [M][v][u] on the lit face
  std::optional<std::string> view_masks;              ///< folder of mask_<face>.npy [v][u]
  std::optional<double> voxel;                        ///< [mm]; a .vdb brings its own
  std::optional<std::string> channel;                 ///< which of a .vdb's
  std::size_t most_voxels = io::default_most_voxels;  ///< of one file's volumes together
};

/// Throws InputError naming file and voxel of the first bad coefficient, and both files where
/// shapes or voxel sizes disagree.
Medium read_medium(const ForwardFiles& files);

struct Irradiance {
  int patterns = 0;
  std::vector<double> values;  ///< [M][v][u]
};
/// The irradiance behind the light mask, where there is one. Throws InputError naming the file
/// unless shapes are that of the lit face, every irradiance is finite and not negative and the mask
/// lies between 0 and 1.
Irradiance read_irradiance(const ForwardFiles& files, const GridShape& grid, Face lit_face);

/// [v][u] of each face, in order of all_faces; empty: the whole face is seen.
using ViewMasks = std::array<std::vector<float>, 6>;
/// Throws InputError naming the folder when it holds no mask, or the file whose shape is not its
/// face's or whose values leave [0, 1].
ViewMasks read_view_masks(const ForwardFiles& files, const GridShape& grid);

}  // namespace kappamu::app
