#include "core/mesh/polygon.h"

#include <Eigen/Geometry>
#include <cstddef>

namespace kappamu {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Twice the area, positive where the corners run counter-clockwise.
double turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  const Vector2d p = b - a, q = c - a;
  return p.x() * q.y() - p.y() * q.x();
}

/// Its corners in the mean plane, which it runs round counter-clockwise.
std::vector<Vector2d> flattened(const std::vector<Vector3d>& corners) {
  Vector3d normal = Vector3d::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    normal += (corners[i] - corners[0]).cross(corners[(i + 1) % corners.size()] - corners[0]);
  }
  const Vector3d across = normal.unitOrthogonal(), up = normal.normalized().cross(across);
  std::vector<Vector2d> flat;
  for (const Vector3d& corner : corners) {
    flat.emplace_back(across.dot(corner - corners[0]), up.dot(corner - corners[0]));
  }
  return flat;
}

/// Whether the triangle of the corner `at` of those left holds no other of them.
bool is_ear(const std::vector<Vector2d>& flat, const std::vector<std::size_t>& left,
            std::size_t at) {
  const std::size_t n = left.size();
  const Vector2d &a = flat[left[(at + n - 1) % n]], &b = flat[left[at]],
                 &c = flat[left[(at + 1) % n]];
  if (!(turn(a, b, c) > 1e-12 * ((b - a).squaredNorm() + (c - b).squaredNorm()))) return false;
  for (const std::size_t other : left) {
    const Vector2d& p = flat[other];
    if (p == a || p == b || p == c) continue;
    if (turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0) return false;
  }
  return true;
}

}  // namespace

void cut_into_triangles(const std::vector<Vector3d>& vertices, std::span<const int> polygon,
                        std::vector<std::array<int, 3>>& triangles) {
  std::vector<Vector3d> corners;
  std::vector<std::size_t> left;
  for (const int v : polygon) {
    left.push_back(left.size());
    corners.push_back(vertices[static_cast<std::size_t>(v)]);
  }
  const std::vector<Vector2d> flat = flattened(corners);
  // Ears are not taken side by side, so that triangles do not fan out from one corner.
  std::size_t at = 0, refused = 0;
  while (left.size() > 2) {
    const std::size_t n = left.size();
    at %= n;
    if (n > 3 && refused < n && !is_ear(flat, left, at)) {
      ++at;
      ++refused;
      continue;
    }
    triangles.push_back(
        {polygon[left[(at + n - 1) % n]], polygon[left[at]], polygon[left[(at + 1) % n]]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
    ++at;
    refused = 0;
  }
}

}  // namespace kappamu
