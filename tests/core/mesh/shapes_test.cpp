#include "core/mesh/shapes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "core/mesh/mesh_check.h"
#include "tests/sentence.h"

namespace kappamu {
namespace {

constexpr double pi = std::numbers::pi;

double total_area(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const double area : surface_of(mesh).area) sum += area;
  return sum;
}

// What a user names is a body as it stands: nothing to mend, nothing to warn of.
TEST(Shapes, EveryNamedShapeIsABody) {
  for (const NamedShape& shape : named_shapes()) {
    for (const int tessellation : {1, 2, 7, 40}) {
      const std::string name(shape.name);
      const TriangleMesh mesh = make_shape(name, 12.5, tessellation);
      const CheckedMesh checked = check_mesh(mesh, name);
      EXPECT_TRUE(checked.mended.empty()) << checked.mended.front();
      EXPECT_TRUE(checked.warnings.empty()) << checked.warnings.front();
      EXPECT_EQ(checked.components, name == "box-with-void" || name == "split-cube" ? 2 : 1);
      EXPECT_TRUE(checked.mesh.triangles == mesh.triangles) << name << tessellation;
      EXPECT_GT(enclosed_volume(mesh), 0.0);
      EXPECT_NEAR(bounding_box(mesh).sizes().maxCoeff(), 12.5, 1e-12);
      EXPECT_LT(bounding_box(mesh).center().norm(), 1e-12);
    }
  }
}

TEST(Shapes, EdgesAreAsLongAsTheTessellationSays) {
  for (const NamedShape& shape : named_shapes()) {
    for (const int tessellation : {40, 80}) {
      const TriangleMesh mesh = make_shape(shape.name, 1.0, tessellation);
      const double area = total_area(mesh) / static_cast<double>(mesh.triangles.size());
      const double edge = std::sqrt(2.0 * area) * tessellation;  // of the square two make
      EXPECT_GT(edge, 0.6) << shape.name;
      EXPECT_LT(edge, 1.3) << shape.name;
    }
  }
}

// Flat triangles inside a round body: volume and area come up as the square of the edge.
TEST(Shapes, RoundBodiesConvergeAtSecondOrder) {
  struct Case {
    TriangleMesh (*make)(int);
    double volume, area;
  };
  const std::vector<Case> cases{
      {[](int n) { return sphere_mesh(1.5, n); }, 4.0 / 3.0 * pi * 3.375, 4.0 * pi * 2.25},
      {[](int n) { return cylinder_mesh(0.5, 2.0, n); }, pi * 0.5, pi * 2.0 + pi * 0.5},
      {[](int n) { return torus_mesh(1.0, 0.25, n); }, 2.0 * pi * pi / 16.0, pi * pi},
      {[](int n) { return cone_mesh(0.5, 1.2, n); }, pi * 0.25 * 0.4, pi * 0.5 * 1.3 + pi * 0.25}};
  for (const Case& c : cases) {
    const TriangleMesh coarse = c.make(40), fine = c.make(80);
    EXPECT_NEAR((c.volume - enclosed_volume(coarse)) / (c.volume - enclosed_volume(fine)), 4.0,
                0.4);
    EXPECT_NEAR((c.area - total_area(coarse)) / (c.area - total_area(fine)), 4.0, 0.4);
    EXPECT_NEAR(enclosed_volume(fine), c.volume, 5e-3 * c.volume);
  }
}

// No triangle of it shades another.
TEST(Shapes, SphereIsConvex) {
  for (const int tessellation : {2, 7, 40}) {
    const TriangleMesh mesh = make_shape("sphere", 2.0, tessellation);
    const Surface surface = surface_of(mesh);
    constexpr double rounding = 1e-9;
    for (std::size_t t = 0; t < surface.size(); ++t) {
      for (const Eigen::Vector3d& vertex : mesh.vertices) {
        ASSERT_LT(surface.normal[t].dot(vertex - surface.position[t]), rounding) << tessellation;
      }
    }
  }
}

TEST(Shapes, ProportionsAreWhatTheyAreCalled) {
  EXPECT_NEAR(enclosed_volume(make_shape("slab", 2.0, 10, 0.3)), 2.4, 1e-12);
  EXPECT_NEAR(enclosed_volume(make_shape("box-with-void", 2.0, 10, 0.3)), 8.0 - 0.216, 1e-12);
  EXPECT_NEAR(enclosed_volume(make_shape("split-cube", 2.0, 10, 0.3)), 5.6, 1e-12);
  EXPECT_NEAR(bounding_box(make_shape("torus", 2.0, 40, 0.3)).sizes().z(), 0.6, 0.01);
  EXPECT_NEAR(bounding_box(make_shape("spike", 2.0, 40, 0.3)).sizes().x(), 0.6, 1e-12);
  EXPECT_NEAR(bounding_box(make_shape("cylinder", 2.0, 40, 0.3)).sizes().x(), 0.6, 0.01);
}

TEST(Shapes, WhatIsNoShapeIsRefused) {
  const double nan = std::nan("");
  EXPECT_THAT(sentence_of([] { make_shape("shpere", 1.0, 4); }),
              testing::HasSubstr("sphere, cube"));
  EXPECT_THAT(sentence_of([] { make_shape("cube", 1.0, 0); }), testing::HasSubstr("tessellation"));
  EXPECT_THAT(sentence_of([] { make_shape("cube", 1.0, 401); }), testing::HasSubstr("1 to 400"));
  EXPECT_THAT(sentence_of([] { make_shape("cube", 1.0, 4, 0.5); }), testing::HasSubstr("none"));
  EXPECT_THAT(sentence_of([] { make_shape("slab", 1.0, 4, 1.0); }),
              testing::HasSubstr("thickness"));
  EXPECT_THAT(sentence_of([&] { make_shape("slab", nan, 4); }), testing::HasSubstr("size_mm"));
  EXPECT_THAT(sentence_of([&] { make_shape("slab", 1.0, 4, nan); }), testing::HasSubstr("nan"));
}

}  // namespace
}  // namespace kappamu
