// Cells, corners and links of a polygrid: lattice cells with the layer upon them
// (forward/polygrid/polygrid.h), before they are mapped, and their refinement.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/polycube.h"
#include "forward/polygrid/polygrid.h"

namespace kappamu::forward {

/// `grid` has cells, corners and links; its nodes and boundary nodes have no positions yet, of the
/// boundary there are only cell and side.
struct LayeredLattice {
  Polygrid grid;
  std::vector<Eigen::Vector3i> core;         ///< core cells, sorted
  std::vector<Eigen::Vector3i> core_corner;  ///< lattice places of the first corners of `grid`
  /// Per core corner: the corner of the surface above it; 0 where it lies deep in the core.
  std::vector<int> outer_of;
  int cells_across = 1;  ///< refinement so far

  /// The corners on the object's surface are those from here on.
  std::size_t first_outer() const { return core_corner.size(); }
};

/// Corners are as the polycube maps them, the layer's outer ones `thickness` times the mean edge
/// beyond along the mean of their faces' normals.
LayeredLattice layered_lattice(const Polycube& polycube, double thickness);

/// Every cell of the core becomes factor³, every cell of the layer factor² (of 1/factor its
/// thickness, the rest of it goes to the core). Corners are mapped as the coarse cells are.
LayeredLattice refined(const LayeredLattice& coarse, int factor);

}  // namespace kappamu::forward
