#include "forward/embedded/geometry/triangle_clip.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace kappamu::forward::embedded {

namespace {

enum class Plane { at_zero, at_one };

/// The part of `polygon` with x[axis] ≥ 0 or ≤ 1.
Polygon cut_by_plane(const Polygon& polygon, int axis, Plane side) {
  const bool upper = side == Plane::at_one;
  const double plane = upper ? 1.0 : 0.0;
  const auto depth = [&](const Eigen::Vector3d& p) { return upper ? 1.0 - p[axis] : p[axis]; };
  Polygon part;
  bool beyond_plane = false;
  for (int i = 0; i < polygon.size; ++i) {
    const Eigen::Vector3d& p = polygon.vertex[static_cast<std::size_t>(i)];
    const Eigen::Vector3d& q = polygon.vertex[static_cast<std::size_t>((i + 1) % polygon.size)];
    const double from = depth(p), to = depth(q);
    if (from >= 0.0) part.vertex[static_cast<std::size_t>(part.size++)] = p;
    beyond_plane = beyond_plane || from > 0.0;
    if ((from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0)) {
      // Always from the vertex below the plane, so that two neighbours make the same point.
      const bool p_first = p[axis] < q[axis];
      const Eigen::Vector3d& a = p_first ? p : q;
      const Eigen::Vector3d& b = p_first ? q : p;
      Eigen::Vector3d crossing = a + (plane - a[axis]) / (b[axis] - a[axis]) * (b - a);
      crossing[axis] = plane;
      part.vertex[static_cast<std::size_t>(part.size++)] = crossing;
    }
  }
  if (part.size < 3 || (!upper && !beyond_plane)) part.size = 0;
  return part;
}

}  // namespace

bool meets_cube(const Triangle& triangle, const Eigen::Vector3d& centre, double half) {
  const double reach = half * (1.0 + 1e-12);
  const Triangle t{triangle[0] - centre, triangle[1] - centre, triangle[2] - centre};
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax({t[0][axis], t[1][axis], t[2][axis]});
    if (low > reach || high < -reach) return false;
  }
  for (const Eigen::Vector3d& corner : t) {
    if (corner.cwiseAbs().maxCoeff() <= half) return true;
  }
  const std::array<Eigen::Vector3d, 3> edge{t[1] - t[0], t[2] - t[1], t[0] - t[2]};
  const Eigen::Vector3d normal = edge[0].cross(edge[1]);
  if (std::abs(normal.dot(t[0])) > reach * normal.cwiseAbs().sum()) return false;
  for (const Eigen::Vector3d& e : edge) {
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d across = Eigen::Vector3d::Unit(axis).cross(e);
      const auto [low, high] = std::minmax({across.dot(t[0]), across.dot(t[1]), across.dot(t[2])});
      const double radius = reach * across.cwiseAbs().sum();
      if (low > radius || high < -radius) return false;
    }
  }
  return true;
}

Polygon clipped_to_unit_cube(const Triangle& triangle) {
  Polygon polygon;
  polygon.size = 3;
  std::copy(triangle.begin(), triangle.end(), polygon.vertex.begin());
  for (int axis = 0; axis < 3 && polygon.size > 0; ++axis) {
    polygon = cut_by_plane(polygon, axis, Plane::at_zero);
    if (polygon.size > 0) polygon = cut_by_plane(polygon, axis, Plane::at_one);
  }
  return polygon;
}

}  // namespace kappamu::forward::embedded
