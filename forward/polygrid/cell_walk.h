// Points of an object in the cells of its polygrid, found by walking from cell to cell.
#pragma once

#include "forward/polygrid/polygrid.h"

namespace kappamu::forward::polygrid {

/// A point's cell and its own coordinates there, in [0, 1].
struct CellPoint {
  int cell = 0;
  Eigen::Vector3d local = Eigen::Vector3d::Constant(0.5);
};

/// The cell that holds `point` [mm], sought from `from` on. A point beyond the boundary is given
/// the place on the boundary that the walk comes to, its coordinates clamped.
CellPoint walk_to(const Polygrid& grid, CellPoint from, const Eigen::Vector3d& point);

/// How the cell's own coordinates change along `direction`, per mm.
Eigen::Vector3d local_direction(const Polygrid& grid, const CellPoint& at,
                                const Eigen::Vector3d& direction);

}  // namespace kappamu::forward::polygrid
