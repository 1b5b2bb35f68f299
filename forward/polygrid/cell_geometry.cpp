#include "forward/polygrid/cell_geometry.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <utility>

namespace kappamu::forward {

using Eigen::Vector3d;

namespace {

const Vector3d& corner_of(const Polygrid& grid, std::size_t cell, int bits) {
  return grid
      .corner[static_cast<std::size_t>(grid.cell_corners[cell][static_cast<std::size_t>(bits)])];
}

}  // namespace

std::array<int, 4> side_corners(int side) {
  const int axis = side / 2, u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3;
  const int first = side % 2 == 0 ? 0 : 1 << axis;
  std::array<int, 4> corners{first, first | u, first | u | v, first | v};
  if (side % 2 == 0) std::swap(corners[1], corners[3]);
  return corners;
}

std::array<int, 4> boundary_corners(const Polygrid& grid, std::size_t boundary_side) {
  const auto& of_cell =
      grid.cell_corners[static_cast<std::size_t>(grid.boundary_cell[boundary_side])];
  std::array<int, 4> corners = side_corners(grid.boundary_side[boundary_side]);
  for (int& corner : corners) corner = of_cell[static_cast<std::size_t>(corner)];
  return corners;
}

CellCorners corners_of(const Polygrid& grid, std::size_t cell) {
  CellCorners corners;
  for (int b = 0; b < 8; ++b) corners[static_cast<std::size_t>(b)] = corner_of(grid, cell, b);
  return corners;
}

Vector3d side_centre(const Polygrid& grid, std::size_t cell, int side) {
  Vector3d sum = Vector3d::Zero();
  for (const int c : side_corners(side)) sum += corner_of(grid, cell, c);
  return sum / 4.0;
}

Vector3d side_area(const Polygrid& grid, std::size_t cell, int side) {
  const auto c = side_corners(side);
  return 0.5 * (corner_of(grid, cell, c[2]) - corner_of(grid, cell, c[0]))
                   .cross(corner_of(grid, cell, c[3]) - corner_of(grid, cell, c[1]));
}

Vector3d within_cell(const Polygrid& grid, std::size_t cell, const Vector3d& u) {
  Vector3d point = Vector3d::Zero();
  for (int b = 0; b < 8; ++b) {
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      weight *= (b >> axis & 1) != 0 ? u[axis] : 1.0 - u[axis];
    }
    point += weight * corner_of(grid, cell, b);
  }
  return point;
}

std::optional<Vector3d> place_in_cell(const Polygrid& grid, std::size_t cell,
                                      const Vector3d& point) {
  constexpr int most_steps = 20;
  constexpr double close = 1e-9;
  Vector3d u = Vector3d::Constant(0.5);
  for (int step = 0; step < most_steps; ++step) {
    const Vector3d off = point - within_cell(grid, cell, u);
    Eigen::Matrix3d by_u;
    for (int axis = 0; axis < 3; ++axis) {
      Vector3d low = u, high = u;
      low[axis] = 0.0;
      high[axis] = 1.0;
      by_u.col(axis) = within_cell(grid, cell, high) - within_cell(grid, cell, low);
    }
    const Vector3d change = by_u.inverse() * off;
    if (!change.allFinite()) return std::nullopt;
    u += change;
    if (change.lpNorm<Eigen::Infinity>() > close) continue;
    if ((u.array() < -close).any() || (u.array() > 1.0 + close).any()) return std::nullopt;
    return u;
  }
  return std::nullopt;
}

double cell_volume(const Polygrid& grid, std::size_t cell) {
  const Vector3d middle = within_cell(grid, cell, Vector3d::Constant(0.5));
  double volume = 0.0;
  for (int side = 0; side < 6; ++side) {
    volume += side_area(grid, cell, side).dot(side_centre(grid, cell, side) - middle) / 3.0;
  }
  return volume;
}

double scaled_jacobian(const Polygrid& grid, std::size_t cell) {
  double least = 1.0;
  for (int b = 0; b < 8; ++b) {
    std::array<Vector3d, 3> edge;
    for (int axis = 0; axis < 3; ++axis) {
      const double sign = (b >> axis & 1) != 0 ? -1.0 : 1.0;
      edge[static_cast<std::size_t>(axis)] =
          sign *
          (corner_of(grid, cell, b ^ 1 << axis) - corner_of(grid, cell, b)).stableNormalized();
    }
    least = std::min(least, edge[0].dot(edge[1].cross(edge[2])));
  }
  return least;
}

TriangleMesh surface_of_grid(const Polygrid& grid) {
  TriangleMesh mesh;
  mesh.vertices = grid.corner;
  for (std::size_t k = 0; k < grid.boundary_cell.size(); ++k) {
    const std::array<int, 4> v = boundary_corners(grid, k);
    mesh.triangles.push_back({v[0], v[1], v[2]});
    mesh.triangles.push_back({v[0], v[2], v[3]});
  }
  return mesh;
}

}  // namespace kappamu::forward
