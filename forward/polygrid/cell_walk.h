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

/// Where a ray is in a cell, and how the cell's own coordinates change along it [1/mm].
struct CellRay {
  CellPoint at;
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
};

/// As walk_to(), the place to a thousandth of the cell.
CellRay ray_at(const Polygrid& grid, CellPoint from, const Eigen::Vector3d& point,
               const Eigen::Vector3d& direction);

/// The side that a ray leaves its cell by, straight on in the cell's own coordinates.
struct CellExit {
  int side = 0;
  double distance = 0.0;  ///< [mm], infinite where the ray stands still
};
CellExit exit_of(const CellRay& ray);

}  // namespace kappamu::forward::polygrid
