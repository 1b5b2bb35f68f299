#include "forward/polygrid/cell_walk.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "forward/polygrid/equations/cell_integrals.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Local coordinates beyond a side by less than this belong to the cell.
constexpr double slack = 1e-6;
constexpr int newton_steps = 6, most_cells = 64;
/// Newton's steps stay near the cell, where its map is one to one.
constexpr double reach = 1.5;
/// Newton's method squares what is left.
constexpr double settled = 1e-3;

struct Mapped {
  Vector3d point;
  Matrix3d jacobian;
};

Mapped mapped(const Polygrid& grid, std::size_t cell, const Vector3d& local) {
  Mapped result{Vector3d::Zero(), Matrix3d::Zero()};
  for (std::size_t c = 0; c < 8; ++c) {
    const Vector3d& corner = grid.corner[static_cast<std::size_t>(grid.cell_corners[cell][c])];
    std::array<double, 3> value{}, slope{};
    for (std::size_t a = 0; a < 3; ++a) {
      const bool far = (c >> a & 1) != 0;
      const double x = local[static_cast<Eigen::Index>(a)];
      value[a] = far ? x : 1.0 - x;
      slope[a] = far ? 1.0 : -1.0;
    }
    result.point += value[0] * value[1] * value[2] * corner;
    result.jacobian.col(0) += slope[0] * value[1] * value[2] * corner;
    result.jacobian.col(1) += value[0] * slope[1] * value[2] * corner;
    result.jacobian.col(2) += value[0] * value[1] * slope[2] * corner;
  }
  return result;
}

/// The point's coordinates in a cell, right near it and of the right side beyond.
Vector3d local_of(const Polygrid& grid, std::size_t cell, Vector3d local, const Vector3d& point) {
  for (int step = 0; step < newton_steps; ++step) {
    const Mapped at = mapped(grid, cell, local);
    const double volume = at.jacobian.determinant();
    if (!(std::abs(volume) > 0.0)) break;
    const Vector3d by = at.jacobian.inverse() * (point - at.point);
    const Vector3d next =
        (local + by).cwiseMax(Vector3d::Constant(-reach)).cwiseMin(Vector3d::Constant(1.0 + reach));
    const double moved = (next - local).cwiseAbs().maxCoeff();
    local = next;
    if (moved < settled) break;
  }
  return local;
}

}  // namespace

CellPoint walk_to(const Polygrid& grid, CellPoint at, const Vector3d& point) {
  int before = -1;
  for (int step = 0; step < most_cells; ++step) {
    const auto cell = static_cast<std::size_t>(at.cell);
    at.local = local_of(grid, cell, at.local, point);
    // Over the side that it lies farthest beyond and that leads to another cell, but not back.
    int next = -1;
    double farthest = slack;
    // Most cells' axes are those of their neighbours; where not, Newton's method has more to do.
    Vector3d start = at.local;
    for (int axis = 0; axis < 3; ++axis) {
      for (const int far : {0, 1}) {
        const double beyond = far != 0 ? at.local[axis] - 1.0 : -at.local[axis];
        const int link = grid.link[cell][static_cast<std::size_t>(2 * axis + far)];
        if (beyond > farthest && link >= 0 && link != before) {
          farthest = beyond;
          next = link;
          start = at.local;
          start[axis] = far != 0 ? start[axis] - 1.0 : start[axis] + 1.0;
        }
      }
    }
    if (next < 0) break;
    before = at.cell;
    at = {next, start.cwiseMax(Vector3d::Zero()).cwiseMin(Vector3d::Ones())};
  }
  at.local = at.local.cwiseMax(Vector3d::Zero()).cwiseMin(Vector3d::Ones());
  return at;
}

Vector3d local_direction(const Polygrid& grid, const CellPoint& at, const Vector3d& direction) {
  const Mapped here = mapped(grid, static_cast<std::size_t>(at.cell), at.local);
  const Vector3d along = here.jacobian.inverse() * direction;
  return along.allFinite() ? along : Vector3d::Zero();
}

}  // namespace kappamu::forward::polygrid
