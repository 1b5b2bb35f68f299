#include "forward/polygrid/cell_walk.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;

/// Local coordinates beyond a side by less than `slack` belong to the cell; Newton's method ends
/// with a step below `settled`, and squares what is left of a cell's size.
struct Exactness {
  double slack, settled;
};
/// A ray that has crossed a side is in the next cell though the side is bent.
constexpr Exactness of_points{1e-6, 1e-3}, of_rays{0.05, 0.1};
constexpr int newton_steps = 6, most_cells = 64;
/// Newton's steps stay near the cell, where its map is one to one.
constexpr double reach = 1.5;

/// A point of a cell, and how it moves with each of the cell's own coordinates.
struct Mapped {
  Vector3d point, by_x, by_y, by_z;
};

Mapped mapped(const Polygrid& grid, std::size_t cell, const Vector3d& local) {
  const auto& of_cell = grid.cell_corners[cell];
  const auto corner = [&](std::size_t c) -> const Vector3d& {
    return grid.corner[static_cast<std::size_t>(of_cell[c])];
  };
  const auto between = [](const Vector3d& a, const Vector3d& b, double t) -> Vector3d {
    return a + t * (b - a);
  };
  std::array<Vector3d, 4> along, edge;  // of the edges along x: their vectors, and points at x
  for (std::size_t k = 0; k < 4; ++k) {
    along[k] = corner(2 * k + 1) - corner(2 * k);
    edge[k] = corner(2 * k) + local[0] * along[k];
  }
  const Vector3d across_low = edge[1] - edge[0], across_high = edge[3] - edge[2];
  const Vector3d low = edge[0] + local[1] * across_low, high = edge[2] + local[1] * across_high;
  return {between(low, high, local[2]),
          between(between(along[0], along[1], local[1]), between(along[2], along[3], local[1]),
                  local[2]),
          between(across_low, across_high, local[2]), high - low};
}

/// The point's coordinates in a cell, right near it and of the right side beyond, and how they
/// change with the point: their gradients.
struct Place {
  Vector3d local;
  std::array<Vector3d, 3> gradient;
};

Place place_of(const Polygrid& grid, std::size_t cell, const Vector3d& start, const Vector3d& point,
               double until) {
  Place place{start, {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()}};
  for (int step = 0; step < newton_steps; ++step) {
    const Mapped at = mapped(grid, cell, place.local);
    const Vector3d across = at.by_y.cross(at.by_z);
    const double volume = at.by_x.dot(across);
    if (!(std::abs(volume) > 0.0)) break;
    const double per_volume = 1.0 / volume;
    place.gradient = {per_volume * across, per_volume * at.by_z.cross(at.by_x),
                      per_volume * at.by_x.cross(at.by_y)};
    const Vector3d off = point - at.point;
    double moved = 0.0;
    for (Eigen::Index a = 0; a < 3; ++a) {
      const double before = place.local[a];
      const double by = place.gradient[static_cast<std::size_t>(a)].dot(off);
      place.local[a] = std::clamp(before + by, -reach, 1.0 + reach);
      moved = std::max(moved, std::abs(place.local[a] - before));
    }
    if (moved < until) break;
  }
  return place;
}

/// walk_to(), with the gradients there.
struct Walked {
  CellPoint at;
  std::array<Vector3d, 3> gradient;
};

Walked walk(const Polygrid& grid, CellPoint at, const Vector3d& point, const Exactness& exactness) {
  std::array<Vector3d, 3> gradient;
  int before = -1;
  for (int step = 0; step < most_cells; ++step) {
    const auto cell = static_cast<std::size_t>(at.cell);
    const Place place = place_of(grid, cell, at.local, point, exactness.settled);
    at.local = place.local;
    gradient = place.gradient;
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
  return {at, gradient};
}

}  // namespace

CellPoint walk_to(const Polygrid& grid, CellPoint from, const Vector3d& point) {
  return walk(grid, from, point, of_points).at;
}

CellRay ray_at(const Polygrid& grid, CellPoint from, const Vector3d& point,
               const Vector3d& direction) {
  const auto [at, gradient] = walk(grid, from, point, of_rays);
  return {at, {gradient[0].dot(direction), gradient[1].dot(direction), gradient[2].dot(direction)}};
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
