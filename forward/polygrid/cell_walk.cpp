#include "forward/polygrid/cell_walk.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "forward/polygrid/equations/cell_integrals.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Local coordinates beyond a side by less than `slack` belong to the cell; Newton's method ends
/// with a step below `settled`, and squares what is left of a cell's size.
struct Exactness {
  double slack, settled;
};
/// A ray that has crossed a side is in the next cell though the side is bent.
constexpr Exactness of_points{1e-6, 1e-3}, of_rays{0.05, 0.03};
constexpr int newton_steps = 6, most_cells = 64;
/// Newton's steps stay near the cell, where its map is one to one.
constexpr double reach = 1.5;

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

/// The point's coordinates in a cell, right near it and of the right side beyond, and how they
/// change with the point.
struct Place {
  Vector3d local;
  Matrix3d by_point;
};

Place place_of(const Polygrid& grid, std::size_t cell, Vector3d local, const Vector3d& point,
               double until) {
  Matrix3d by_point = Matrix3d::Zero();
  for (int step = 0; step < newton_steps; ++step) {
    const Mapped at = mapped(grid, cell, local);
    const double volume = at.jacobian.determinant();
    if (!(std::abs(volume) > 0.0)) break;
    by_point = at.jacobian.inverse();
    const Vector3d by = by_point * (point - at.point);
    const Vector3d next =
        (local + by).cwiseMax(Vector3d::Constant(-reach)).cwiseMin(Vector3d::Constant(1.0 + reach));
    const double moved = (next - local).cwiseAbs().maxCoeff();
    local = next;
    if (moved < until) break;
  }
  return {local, by_point};
}

/// walk_to(); `by_point` as Place has it.
CellPoint walk(const Polygrid& grid, CellPoint at, const Vector3d& point,
               const Exactness& exactness, Matrix3d& by_point) {
  int before = -1;
  for (int step = 0; step < most_cells; ++step) {
    const auto cell = static_cast<std::size_t>(at.cell);
    const Place place = place_of(grid, cell, at.local, point, exactness.settled);
    at.local = place.local;
    by_point = place.by_point;
    // Over the side that it lies farthest beyond and that leads to another cell, but not back.
    int next = -1;
    double farthest = exactness.slack;
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

}  // namespace

CellPoint walk_to(const Polygrid& grid, CellPoint from, const Vector3d& point) {
  Matrix3d by_point;
  return walk(grid, from, point, of_points, by_point);
}

CellRay ray_at(const Polygrid& grid, CellPoint from, const Vector3d& point,
               const Vector3d& direction) {
  Matrix3d by_point;
  CellRay ray;
  ray.at = walk(grid, from, point, of_rays, by_point);
  ray.along = by_point * direction;
  return ray;
}

CellExit exit_of(const CellRay& ray) {
  CellExit exit;
  exit.distance = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double slope = ray.along[axis];
    if (!(std::abs(slope) > 0.0)) continue;
    const double far = slope > 0.0 ? 1.0 : 0.0, distance = (far - ray.at.local[axis]) / slope;
    if (distance >= exit.distance) continue;
    exit.distance = distance;
    exit.side = 2 * axis + static_cast<int>(far);
  }
  return exit;
}

}  // namespace kappamu::forward::polygrid
