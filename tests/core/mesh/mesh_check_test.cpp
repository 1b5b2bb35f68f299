#include "core/mesh/mesh_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include "core/mesh/shapes.h"
#include "tests/sentence.h"

namespace kappamu {
namespace {

using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TriangleMesh ball() {
  return sphere_mesh(5.0, 12);
}

/// Three vertices of its own to every triangle, as in STL.
TriangleMesh soup(const TriangleMesh& mesh) {
  TriangleMesh apart;
  for (const auto& triangle : mesh.triangles) {
    const int first = static_cast<int>(apart.vertices.size());
    for (const int v : triangle)
      apart.vertices.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  return apart;
}

std::string refusal(const TriangleMesh& mesh) {
  return sentence_of([&] { check_mesh(mesh, "a.obj"); });
}

/// Closed and facing outwards: the same volume and flux as the mesh it should be.
void expect_same_body(const CheckedMesh& checked, const TriangleMesh& expected) {
  EXPECT_NEAR(enclosed_volume(checked.mesh), enclosed_volume(expected),
              1e-5 * std::abs(enclosed_volume(expected)));
  Vector3d closed = Vector3d::Zero();  // ∮ n dA = 0
  const Surface surface = surface_of(checked.mesh);
  for (std::size_t i = 0; i < surface.size(); ++i) {
    closed += surface.area[i] * surface.normal[i];
    EXPECT_GT(surface.area[i], 0.0);
  }
  EXPECT_LT(closed.norm(), 1e-3);
}

TEST(MeshCheck, TrianglesOfStlAreWelded) {
  const CheckedMesh checked = check_mesh(soup(ball()), "a.stl");
  expect_same_body(checked, ball());
  EXPECT_EQ(checked.mesh.vertices.size(), ball().vertices.size());
  EXPECT_EQ(checked.mesh.triangles.size(), ball().triangles.size());
  EXPECT_THAT(checked.mended, IsEmpty());
}

// Rounded apart by a ten-millionth of the box, as some exporters do.
TEST(MeshCheck, NearlyEqualVerticesOfOpenEdgesAreWelded) {
  TriangleMesh mesh = soup(ball());
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(-1e-6, 1e-6);
  for (Vector3d& vertex : mesh.vertices) {
    vertex += Vector3d(noise(random), noise(random), noise(random));
  }
  const CheckedMesh checked = check_mesh(mesh, "a.stl");
  expect_same_body(checked, ball());
  EXPECT_EQ(checked.mesh.vertices.size(), ball().vertices.size());
}

TEST(MeshCheck, OrientationIsMended) {
  TriangleMesh mesh = ball();
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 7) {
    std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  }
  const CheckedMesh mixed = check_mesh(mesh, "a.obj");
  expect_same_body(mixed, ball());
  const std::string seventh = std::to_string((mesh.triangles.size() + 6) / 7);
  EXPECT_THAT(mixed.mended, testing::Contains(HasSubstr(": " + seventh + " triangles turned")));

  const CheckedMesh inwards = check_mesh(turned_inside_out(ball()), "a.obj");
  expect_same_body(inwards, ball());
  EXPECT_THAT(inwards.mended, ElementsAre(HasSubstr("1 body that faced inwards")));
}

// A shell, a body inside its void and a void in that: whatever way each was given.
TEST(MeshCheck, NestedSurfacesBecomeVoidsAndBodies) {
  const TriangleMesh nest =
      joined(joined(sphere_mesh(5.0, 12), turned_inside_out(sphere_mesh(4.0, 10))),
             joined(sphere_mesh(3.0, 8), turned_inside_out(box_mesh(Vector3d::Ones(), 3))));
  EXPECT_THAT(check_mesh(nest, "a.obj").mended, IsEmpty());
  const TriangleMesh wrong =
      joined(joined(turned_inside_out(sphere_mesh(5.0, 12)), sphere_mesh(4.0, 10)),
             joined(sphere_mesh(3.0, 8), box_mesh(Vector3d::Ones(), 3)));
  const CheckedMesh checked = check_mesh(wrong, "a.obj");
  expect_same_body(checked, nest);
  EXPECT_EQ(checked.components, 4);
  EXPECT_THAT(checked.mended, ElementsAre(HasSubstr("1 body that faced inwards"),
                                          HasSubstr("2 surfaces inside another made a void")));
}

TEST(MeshCheck, UselessTrianglesAndVerticesAreDropped) {
  TriangleMesh mesh = ball();
  mesh.vertices.emplace_back(90.0, 90.0, 90.0);
  mesh.triangles.push_back({3, 3, 5});
  mesh.triangles.push_back(mesh.triangles[10]);
  const CheckedMesh checked = check_mesh(mesh, "a.obj");
  expect_same_body(checked, ball());
  EXPECT_TRUE(checked.mesh.triangles == ball().triangles);
  EXPECT_THAT(checked.mended, ElementsAre(HasSubstr("1 triangle without area dropped"),
                                          HasSubstr("1 triangle given twice dropped"),
                                          HasSubstr("1 vertex of no triangle dropped")));
}

// A vertex in the middle of an edge on one side of it only, closed by a triangle on a line; and a
// triangle of two vertices at one place.
TEST(MeshCheck, TrianglesWithoutAreaAreMended) {
  TriangleMesh mesh = box_mesh({2.0, 2.0, 2.0}, 2);
  const auto [a, b, c] = mesh.triangles[0];
  const auto at = [&](int v) { return mesh.vertices[static_cast<std::size_t>(v)]; };
  const int middle = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(0.5 * (at(a) + at(b)));
  mesh.triangles[0] = {a, middle, c};
  mesh.triangles.push_back({middle, b, c});
  mesh.triangles.push_back({a, b, middle});
  const CheckedMesh cap = check_mesh(mesh, "a.obj");
  expect_same_body(cap, box_mesh({2.0, 2.0, 2.0}, 2));
  EXPECT_THAT(cap.mended, ElementsAre(HasSubstr("1 triangle on a line given area")));

  TriangleMesh needle = box_mesh({2.0, 2.0, 2.0}, 2);
  // The edge from a to b opens into two, with a needle along a to its twin.
  const int twin = static_cast<int>(needle.vertices.size());
  needle.vertices.emplace_back(at(a) + Vector3d(0.0, 1e-8, 1e-8));
  needle.triangles[0] = {twin, b, c};
  needle.triangles.push_back({a, b, twin});
  needle.triangles.push_back({a, twin, c});
  const CheckedMesh collapsed = check_mesh(needle, "a.obj");
  expect_same_body(collapsed, box_mesh({2.0, 2.0, 2.0}, 2));
  EXPECT_EQ(collapsed.mesh.triangles.size(), box_mesh({2.0, 2.0, 2.0}, 2).triangles.size());
}

// What is mended does not change the numbers that sentences give.
TEST(MeshCheck, TrianglesKeepTheirNumbers) {
  TriangleMesh mesh = ball();
  mesh.triangles.insert(mesh.triangles.begin() + 4, {7, 7, 8});
  const CheckedMesh checked = check_mesh(mesh, "a.obj");
  ASSERT_EQ(checked.source.size(), checked.mesh.triangles.size());
  EXPECT_EQ(checked.source[3], 3);
  EXPECT_EQ(checked.source[4], 5);
}

TEST(MeshCheck, TwoBodiesThatShareAnEdgeAreTwo) {
  const TriangleMesh one = box_mesh(Vector3d::Ones(), 2);
  const CheckedMesh checked = check_mesh(joined(one, moved(one, {1.0, 1.0, 0.0})), "a.obj");
  EXPECT_EQ(checked.components, 2);
  EXPECT_NEAR(enclosed_volume(checked.mesh), 2.0, 1e-12);
}

TEST(MeshCheck, AHoleIsRefusedWithItsPlace) {
  TriangleMesh mesh = box_mesh({2.0, 2.0, 2.0}, 1);
  mesh.triangles.erase(mesh.triangles.begin() + 3);
  EXPECT_THAT(refusal(mesh),
              testing::MatchesRegex("a.obj: is not closed: it has 3 open edges, the first at "
                                    "\\(.*\\) \\(triangle [0-9]+\\); close the hole there"));
}

TEST(MeshCheck, WhatBoundsNoVolumeIsRefused) {
  const double nan = std::nan("");
  EXPECT_THAT(refusal({}), HasSubstr("no triangles"));
  TriangleMesh mesh = ball();
  mesh.vertices[5].y() = nan;
  EXPECT_THAT(refusal(mesh), HasSubstr("vertex 5"));
  mesh = ball();
  mesh.triangles[9][1] = 100000;
  EXPECT_THAT(refusal(mesh), HasSubstr("triangle 9 has vertex 100000"));
  mesh = ball();
  for (Vector3d& vertex : mesh.vertices) vertex.z() = 0.0;
  EXPECT_THAT(refusal(mesh), HasSubstr("encloses a volume"));
  mesh = ball();  // a wall inside
  mesh.triangles.push_back({mesh.triangles[0][0], mesh.triangles[0][1], 400});
  EXPECT_THAT(refusal(mesh), HasSubstr("is not closed"));
  mesh = box_mesh(Vector3d::Ones(), 1);  // two rooms with a wall between them
  EXPECT_THAT(refusal(joined(mesh, moved(mesh, {1.0, 0.0, 0.0}))), HasSubstr("an odd number"));
}

// A Klein bottle's grid: closed, and with one side.
TEST(MeshCheck, OneSideOnlyIsRefused) {
  TriangleMesh mesh;
  constexpr int n = 12;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(0.0, 1.0);
  for (int v = 0; v < n * n; ++v) {
    mesh.vertices.emplace_back(anywhere(random), anywhere(random), anywhere(random));
  }
  const auto vertex = [](int i, int j) {
    const bool crossed = i == n;
    return (i % n) * n + ((crossed ? n - j : j) + n) % n;
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  }
  EXPECT_THAT(refusal(mesh), HasSubstr("one side only"));
}

TEST(MeshCheck, OverlappingBodiesAreRefused) {
  const auto refused = testing::AllOf(HasSubstr("two of its bodies intersect"), HasSubstr("unite"));
  EXPECT_THAT(refusal(joined(ball(), moved(ball(), {4.0, 1.0, 0.0}))), refused);
  // However little of the surface overlaps.
  EXPECT_THAT(
      refusal(joined(sphere_mesh(5.0, 100), moved(cone_mesh(0.05, 1.0, 40), {0, 0, -5.49}))),
      refused);
}

// A small cube in the corner, on an edge or on a face of a large one, within it or outside: upon
// it, and no void.
TEST(MeshCheck, SmallBodiesUponTheSurfaceOfAnotherAreRefused) {
  const TriangleMesh large = box_mesh(Vector3d::Constant(2.0), 3);
  const TriangleMesh small = box_mesh(Vector3d::Constant(0.02), 1);
  for (const Vector3d& at : {Vector3d(0.99, 0.99, 0.99), Vector3d(0.99, 0.3, 0.99),
                             Vector3d(0.17, -0.99, 0.2), Vector3d(0.17, -1.01, 0.2)}) {
    EXPECT_THAT(refusal(joined(large, moved(small, at))), HasSubstr("two of its bodies"))
        << at.transpose();
  }
  // A true void stays one.
  EXPECT_EQ(check_mesh(joined(large, moved(small, {0.985, 0.985, 0.985})), "a.obj").components, 2);
}

// The same in a file whose positions are rounded to 24 bits: the corner's faces lie 1e-8 to 1e-7 of
// the body apart, inside or outside.
TEST(MeshCheck, SmallBodiesInARoundedCornerAreRefused) {
  const TriangleMesh large = box_mesh(Vector3d::Constant(2.0), 3);
  for (const double gap : {1e-8, 1e-7, -1e-7}) {
    const TriangleMesh small =
        moved(box_mesh(Vector3d::Constant(0.02), 1), Vector3d::Constant(0.99 - gap));
    EXPECT_THAT(refusal(joined(large, small)), HasSubstr("two of its bodies")) << gap;
  }
}

// No edge of either passes through a triangle of the other: the octahedron's equator lies in the
// cube's face, and the face's diagonal meets edges of the octahedron.
TEST(MeshCheck, ABodyHalfInsideByCornersAndEdgesAloneIsRefused) {
  constexpr double h = 0.1;
  TriangleMesh octahedron;
  octahedron.vertices = {{1 + h, 0, 0}, {1 - h, 0, 0}, {1, h, 0},
                         {1, 0, h},     {1, -h, 0},    {1, 0, -h}};
  for (int k = 0; k < 4; ++k) {
    const int one = 2 + k, next = 2 + (k + 1) % 4;
    octahedron.triangles.push_back({0, one, next});
    octahedron.triangles.push_back({1, next, one});
  }
  const TriangleMesh cube = box_mesh(Vector3d::Constant(2.0), 1);
  EXPECT_THAT(refusal(joined(cube, octahedron)), HasSubstr("partly inside another"));
  EXPECT_EQ(check_mesh(joined(cube, moved(octahedron, {-0.5, 0, 0})), "a.obj").components, 2);
  EXPECT_EQ(check_mesh(joined(cube, moved(octahedron, {0.5, 0, 0})), "a.obj").components, 2);
}

// A fold of a few triangles, as scans have it: reported, and left.
TEST(MeshCheck, SmallSelfIntersectionsAreReported) {
  TriangleMesh mesh = sphere_mesh(5.0, 100);
  Vector3d& leaning = mesh.vertices[mesh.vertices.size() / 3];
  const Vector3d aside = leaning.cross(Vector3d(0.3, -0.4, 0.5)).normalized();
  const Vector3d below = 5.0 * (leaning + 0.3 * aside).normalized();
  leaning = 5.1 * (leaning + 0.6 * aside).normalized();
  // One from below through the spike.
  *std::min_element(mesh.vertices.begin(), mesh.vertices.end(),
                    [&](const Vector3d& a, const Vector3d& b) {
                      return (a - below).norm() < (b - below).norm();
                    }) *= 1.05;
  EXPECT_THAT(check_mesh(mesh, "a.obj").warnings, ElementsAre(HasSubstr("each other")));
}

// Faces in one plane: neither a ray nor a grid can tell what lies between them.
TEST(MeshCheck, BodiesThatTouchByTheirFacesAreRefused) {
  const TriangleMesh one = box_mesh(Vector3d::Ones(), 2);
  EXPECT_THAT(refusal(joined(one, moved(one, {1.0, 0.25, 0.25}))),
              HasSubstr("lie upon each other"));
}

TEST(MeshCheck, LimitsAreStated) {
  TriangleMesh many = ball();
  many.triangles.resize(most_triangles + 1, many.triangles.front());
  EXPECT_THAT(refusal(many), testing::AllOf(HasSubstr("2000001"), HasSubstr("decimate")));
  TriangleMesh crumbs;
  const TriangleMesh crumb = box_mesh(Vector3d::Constant(0.5), 1);
  for (int i = 0; i <= most_components; ++i) crumbs = joined(crumbs, moved(crumb, {1.0 * i, 0, 0}));
  EXPECT_THAT(refusal(crumbs), HasSubstr("1001 separate surfaces"));
}

}  // namespace
}  // namespace kappamu
