// Polygrids for the tests of forward/polygrid: sets of lattice cells under analytic maps, without a
// layer on their surface (polygrid.h).
#pragma once

#include <functional>

#include "core/mesh/triangle_mesh.h"
#include "forward/polygrid/polygrid.h"

namespace kappamu::forward::polygrid {

using Map = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// The cells [0, n) under the map of their corners, which are given as place/n.
Polygrid mapped_box(const Eigen::Vector3i& n, const Map& map);
/// A box of `size` [mm].
Polygrid box_polygrid(const Eigen::Vector3i& n, const Eigen::Vector3d& size);
/// A box of about 4 × 3 × 2 mm whose edges and sides are bent.
Polygrid bent_polygrid(const Eigen::Vector3i& n);
/// A ball about the origin, n³ cells, by the map of a cube under which volumes stay nearly equal.
Polygrid ball_polygrid(int n, double radius);

}  // namespace kappamu::forward::polygrid
