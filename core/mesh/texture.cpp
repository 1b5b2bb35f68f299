#include "core/mesh/texture.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/numbers/at.h"

namespace kappamu {

namespace {

using Eigen::Vector3d;

/// At a point of the plane of the triangle a b c, or of its longest edge where it has no area.
Eigen::Vector2f texture_at(const Vector3d& point, const Vector3d& a, const Vector3d& b,
                           const Vector3d& c, const CornerTexture& texture) {
  const Vector3d one = b - a, other = c - a, from_a = point - a;
  const Vector3d normal = one.cross(other);
  Eigen::Vector2d weights(from_a.cross(other).dot(normal), one.cross(from_a).dot(normal));
  // Twice the area of a triangle whose edges differ by rounding alone.
  constexpr double no_area = 1e-12;
  const double longest = std::max(one.squaredNorm(), other.squaredNorm());
  if (normal.norm() > no_area * longest) {
    weights /= normal.squaredNorm();
  } else {
    const bool first = one.squaredNorm() >= other.squaredNorm();
    weights = first ? Eigen::Vector2d::UnitX() : Eigen::Vector2d::UnitY();
    weights *= longest > 0.0 ? from_a.dot(first ? one : other) / longest : 0.0;
  }
  const Eigen::Vector2d origin = texture[0].cast<double>();
  Eigen::Matrix2d along;
  along << texture[1].cast<double>() - origin, texture[2].cast<double>() - origin;
  return (origin + along * weights).cast<float>();
}

}  // namespace

std::vector<CornerTexture> texture_from(const TriangleMesh& given, const TriangleMesh& mesh,
                                        const std::vector<int>& source) {
  std::vector<CornerTexture> result;
  if (given.texture.empty()) return result;
  result.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::size_t from = at(source[t]);
    const auto corner = [&](std::size_t k) -> const Vector3d& {
      return given.vertices[at(given.triangles[from][k])];
    };
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d& point = mesh.vertices[at(mesh.triangles[t][k])];
      std::size_t same = 0;
      while (same < 3 && corner(same) != point) ++same;
      result[t][k] = same < 3
                         ? given.texture[from][same]
                         : texture_at(point, corner(0), corner(1), corner(2), given.texture[from]);
    }
  }
  return result;
}

}  // namespace kappamu
