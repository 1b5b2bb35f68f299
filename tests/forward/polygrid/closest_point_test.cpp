// Closest points of meshes against what is known of spheres, and against every triangle in turn.
#include "forward/polygrid/closest_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "core/mesh/shapes.h"

namespace kappamu::forward {
namespace {

using Eigen::Vector3d;

Vector3d closest_in_triangle(const Vector3d& point, const Vector3d& a, const Vector3d& b,
                             const Vector3d& c) {
  const Vector3d weights = closest_weights(point, a, b, c);
  return weights[0] * a + weights[1] * b + weights[2] * c;
}

TEST(ClosestPoint, IsThatOfAllTriangles) {
  const TriangleMesh mesh = torus_mesh(3.0, 1.0, 12);
  const ClosestPoint closest(mesh);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-5.0, 5.0);
  for (int i = 0; i < 200; ++i) {
    const Vector3d point(uniform(random), uniform(random), uniform(random));
    double least = std::numeric_limits<double>::infinity();
    for (const auto& t : mesh.triangles) {
      const auto v = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
      least = std::min(least, (closest_in_triangle(point, v(0), v(1), v(2)) - point).norm());
    }
    const auto found = closest.from(point, i);
    EXPECT_EQ(found.triangle, closest.from(point).triangle);
    EXPECT_DOUBLE_EQ(found.distance, least);
    EXPECT_NEAR((found.point - point).norm(), found.distance, 1e-12);
  }
}

TEST(ClosestPoint, OfATriangleIsAtACornerOnAnEdgeOrWithin) {
  const Vector3d a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
  EXPECT_EQ(closest_in_triangle({-1, -1, 3}, a, b, c), a);
  EXPECT_EQ(closest_in_triangle({5, -1, 0}, a, b, c), b);
  EXPECT_EQ(closest_in_triangle({-1, 5, 1}, a, b, c), c);
  EXPECT_EQ(closest_in_triangle({1, -2, 0}, a, b, c), Vector3d(1, 0, 0));
  EXPECT_EQ(closest_in_triangle({-2, 1, 0}, a, b, c), Vector3d(0, 1, 0));
  EXPECT_EQ(closest_in_triangle({2, 2, 1}, a, b, c), Vector3d(1, 1, 0));
  EXPECT_LT((closest_in_triangle({0.5, 0.5, 4}, a, b, c) - Vector3d(0.5, 0.5, 0)).norm(), 1e-15);
}

TEST(ClosestPoint, SmoothNormalsOfASphereAreRadial) {
  const TriangleMesh mesh = sphere_mesh(1.0, 24);
  const ClosestPoint closest(mesh);
  for (const Vector3d& direction :
       {Vector3d(1, 2, 3), Vector3d(-3, 0.1, 0.2), Vector3d(0, 0, -1)}) {
    const Vector3d n = direction.normalized();
    const auto found = closest.from(1.5 * n);
    EXPECT_GT(closest.smooth_normal(found).dot(n), 0.999);
    EXPECT_GT(closest.normal(found.triangle).dot(n), 0.99);
  }
}

}  // namespace
}  // namespace kappamu::forward
