// The unknowns of a medium: the voxels of a box, or those of them that lie inside an object. What
// an inverse problem regularises, and the metric that it moves in, are made of this alone, so that
// a block and an object are fitted by the same code.
#pragma once

#include <cstddef>
#include <vector>

#include "core/grid.h"

namespace kappamu::forward {

/// Arrays over a medium are [z][y][x] of the whole box. No equation and no regulariser reads voxels
/// outside an object, and every derivative is 0 there.
struct MediumSpace {
  GridShape shape;
  int depth_axis = 2;         ///< 0, 1, 2 for x, y, z: along the light
  double thickness_mm = 1.0;  ///< ℓ, of the box along the light
  /// Share of each voxel's volume that lies inside; empty: 1 everywhere, a block.
  std::vector<float> fraction{};

  std::size_t cells() const { return shape.cells(); }
  int depth() const { return shape.extent(depth_axis); }
  bool inside(std::size_t voxel) const { return fraction.empty() || fraction[voxel] > 0.0F; }
};

/// All of a block's voxels, lit through `lit`.
inline MediumSpace block_space(const GridShape& shape, Face lit) {
  const int axis = axis_of(lit);
  return {shape, axis, shape.extent(axis) * shape.voxel_mm};
}

/// One value per voxel for each coefficient, [z][y][x].
struct CoefficientPair {
  std::vector<double> log_kappa;  ///< κ in mm
  std::vector<double> log_mu;     ///< μ in 1/mm

  bool operator==(const CoefficientPair&) const = default;
};

}  // namespace kappamu::forward
