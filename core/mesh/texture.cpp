#include "core/mesh/texture.h"

#include <Eigen/Dense>

#include "core/numbers/at.h"

namespace kappamu {

namespace {

using Eigen::Vector3d;

/// At a point of the plane of the triangle a b c, or of its longest edge where it has no area.
Eigen::Vector2f texture_at(const Vector3d& point, const Vector3d& a, const Vector3d& b,
                           const Vector3d& c, const CornerTexture& texture) {
  const Eigen::Vector2d origin = texture[0].cast<double>();
  Eigen::Matrix2d along;
  along << texture[1].cast<double>() - origin, texture[2].cast<double>() - origin;
  Eigen::Matrix<double, 3, 2> edges;
  edges << b - a, c - a;
  const Eigen::Vector2d weights = edges.completeOrthogonalDecomposition().solve(point - a);
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
