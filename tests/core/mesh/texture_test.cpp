// Texture of meshes made of another one: linear over triangles, along their longest edge where they
// have no area.
#include "core/mesh/texture.h"

#include <gtest/gtest.h>

namespace kappamu {
namespace {

/// One triangle with corners a, b, c, and its texture.
TriangleMesh given(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  TriangleMesh mesh;
  mesh.vertices = {a, b, c};
  mesh.triangles = {{0, 1, 2}};
  mesh.texture = {{Eigen::Vector2f(0.1F, 0.2F), {0.9F, 0.3F}, {0.4F, 0.8F}}};
  return mesh;
}

/// At a point of the triangle.
Eigen::Vector2f texture_at(const TriangleMesh& mesh, const Eigen::Vector3d& point) {
  TriangleMesh made = mesh;
  made.vertices.push_back(point);
  made.triangles = {{0, 1, 3}};
  return texture_from(mesh, made, {0})[0][2];
}

TEST(Texture, IsLinearOverATriangle) {
  const TriangleMesh mesh = given({1.0, 2.0, 3.0}, {4.0, 2.5, 3.0}, {1.5, 5.0, 4.0});
  const auto& v = mesh.vertices;
  const auto& uv = mesh.texture[0];
  const Eigen::Vector3d point = 0.5 * v[0] + 0.3 * v[1] + 0.2 * v[2];
  const Eigen::Vector2f expected = 0.5F * uv[0] + 0.3F * uv[1] + 0.2F * uv[2];
  EXPECT_LT((texture_at(mesh, point) - expected).norm(), 1e-6F);
}

TEST(Texture, FollowsTheLongestEdgeWhereThereIsNoArea) {
  const TriangleMesh mesh = given({0.0, 0.0, 0.0}, {1.0, 1.0, 0.0}, {3.0, 3.0, 0.0});
  const auto& uv = mesh.texture[0];
  const Eigen::Vector2f expected = uv[0] + 0.5F * (uv[2] - uv[0]);
  EXPECT_LT((texture_at(mesh, {1.5, 1.5, 0.0}) - expected).norm(), 1e-6F);
}

}  // namespace
}  // namespace kappamu
