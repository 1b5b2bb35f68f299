// Points of the unit square turned into points of triangles and directions.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/mesh/triangle_mesh.h"

namespace kappamu::render {

/// A point of a triangle, even over its area [mm].
inline Eigen::Vector3d point_on(const TriangleMesh& mesh, std::size_t triangle, double u,
                                double v) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  const auto corner = [&](int i) -> const Eigen::Vector3d& {
    return mesh.vertices[static_cast<std::size_t>(i)];
  };
  // The square's upper half is folded onto its lower: nearby points stay near.
  const bool upper = u + v > 1.0;
  return corner(a) + (upper ? 1.0 - u : u) * (corner(b) - corner(a)) +
         (upper ? 1.0 - v : v) * (corner(c) - corner(a));
}

/// Two directions that make a right-handed frame with `normal` (Duff et al. 2017).
inline Eigen::Matrix3d frame_about(const Eigen::Vector3d& normal) {
  const double sign = std::copysign(1.0, normal.z());
  const double a = -1.0 / (sign + normal.z());
  const double b = normal.x() * normal.y() * a;
  Eigen::Matrix3d frame;
  frame.col(0) << 1.0 + sign * normal.x() * normal.x() * a, sign * b, -sign * normal.x();
  frame.col(1) << b, sign + normal.y() * normal.y() * a, -normal.y();
  frame.col(2) = normal;
  return frame;
}

/// Of density cosθ/π about `normal`.
inline Eigen::Vector3d cosine_direction(const Eigen::Vector3d& normal, double u, double v) {
  const double radius = std::sqrt(u), angle = 2.0 * std::numbers::pi * v;
  return frame_about(normal) * Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle),
                                               std::sqrt(std::max(0.0, 1.0 - u)));
}

}  // namespace kappamu::render
