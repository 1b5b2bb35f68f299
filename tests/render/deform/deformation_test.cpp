// Deformations by laws: what they keep, what they undo, where they end; and what a body does not
// bear.
#include "render/deform/deformation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/mesh/shapes.h"
#include "core/random.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;

Deformation of(DeformKind kind, double amount) {
  return {.kind = kind, .amount = amount};
}

Deformation within(Deformation deformation, const Vector3d& centre, double radius) {
  deformation.brush = DeformBrush{centre, radius};
  return deformation;
}

TriangleMesh deformed_by(const TriangleMesh& mesh, const Deformation& deformation) {
  return deformed(mesh, std::span(&deformation, 1));
}

/// Largest distance between vertices of the two.
double apart(const TriangleMesh& one, const TriangleMesh& other) {
  double most = 0.0;
  for (std::size_t v = 0; v < one.vertices.size(); ++v) {
    most = std::max(most, (one.vertices[v] - other.vertices[v]).norm());
  }
  return most;
}

class EveryKind : public testing::TestWithParam<DeformKind> {
 protected:
  static Deformation some(double amount) {
    Deformation deformation = of(GetParam(), amount);
    deformation.wavelength_mm = 4.0;
    return within(deformation, {6.0, 1.0, 0.5}, 5.0);
  }
};

TEST_P(EveryKind, MovesNothingWithoutAnAmountAndNothingOutsideItsBrush) {
  const TriangleMesh mesh = make_shape("torus", 20.0, 40);
  const double nothing = GetParam() == DeformKind::scale ? 1.0 : 0.0;
  EXPECT_LT(apart(mesh, deformed_by(mesh, some(nothing))), 1e-12);
  const Deformation deformation = some(GetParam() == DeformKind::scale ? 1.3 : 0.7);
  const TriangleMesh moved = deformed_by(mesh, deformation);
  double most = 0.0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const double by = (moved.vertices[v] - mesh.vertices[v]).norm();
    const bool outside = (mesh.vertices[v] - deformation.brush->centre_mm).norm() >= 5.0;
    EXPECT_TRUE(!outside || by == 0.0);
    most = std::max(most, by);
  }
  EXPECT_GT(most, 0.005);
}

INSTANTIATE_TEST_SUITE_P(Kinds, EveryKind,
                         testing::Values(DeformKind::pull, DeformKind::dent, DeformKind::twist,
                                         DeformKind::bend, DeformKind::inflate, DeformKind::noise,
                                         DeformKind::scale));

TEST(DeformBrush, FallsSmoothlyFromItsInsideToItsEdge) {
  const DeformBrush brush{{1.0, 2.0, 3.0}, 4.0, 0.5};
  const auto at = [&](double distance) {
    return brush.weight(brush.centre_mm + distance * Vector3d(0.6, 0.0, 0.8));
  };
  EXPECT_EQ(at(0.0), 1.0);
  EXPECT_EQ(at(1.99), 1.0);
  EXPECT_NEAR(at(3.0), 0.5, 1e-12);
  EXPECT_EQ(at(4.0), 0.0);
  for (double d = 0.0; d < 5.0; d += 0.01) {
    EXPECT_LE(at(d + 0.01), at(d));
    EXPECT_LT(at(d) - at(d + 0.01), 0.01);  // steepest slope: 1.5 / 2 mm
  }
}

TEST(Deform, TwistKeepsHeightsDistancesFromTheAxisAndTurnsEndsByTheAngle) {
  const TriangleMesh mesh = make_shape("candle", 30.0, 50);
  Deformation twist = of(DeformKind::twist, 75.0);
  twist.axis = Vector3d::UnitZ();
  const TriangleMesh moved = deformed_by(mesh, twist);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vector3d &from = mesh.vertices[v], &to = moved.vertices[v];
    EXPECT_NEAR(to.z(), from.z(), 1e-12);
    EXPECT_NEAR(to.head<2>().norm(), from.head<2>().norm(), 1e-12);
    const double angle = 75.0 * pi / 180.0 * from.z() / 30.0;
    const Vector3d expected = Eigen::AngleAxisd(angle, Vector3d::UnitZ()) * from;
    EXPECT_LT((to - expected).norm(), 1e-12);
  }
  // An equal twist against it undoes it: it keeps the axis's places.
  twist.amount = -75.0;
  EXPECT_LT(apart(mesh, deformed_by(moved, twist)), 1e-12);
}

// Barr: bending keeps volume to the first order of the angle and lengths on the axis exactly.
TEST(Deform, BendMakesAnArcOfTheAxisAndKeepsItStraightBeyond) {
  TriangleMesh line;
  for (int i = 0; i <= 200; ++i) line.vertices.emplace_back(0.0, 0.2 * i - 20.0, 0.0);
  Deformation bend = of(DeformKind::bend, 120.0);
  bend.length_mm = 16.0;
  const TriangleMesh moved = deformed_by(line, bend);
  for (std::size_t v = 0; v + 1 < line.vertices.size(); ++v) {
    EXPECT_NEAR((moved.vertices[v + 1] - moved.vertices[v]).norm(), 0.2, 1e-4);
  }
  const auto direction = [&](std::size_t v) -> Vector3d {
    return (moved.vertices[v + 1] - moved.vertices[v]).normalized();
  };
  EXPECT_NEAR(std::acos(direction(0).dot(direction(199))) * 180.0 / pi, 120.0, 1e-9);
  EXPECT_LT((direction(0) - direction(50)).norm(), 1e-9);  // 20 to 10 mm below the middle
  EXPECT_GT(moved.vertices[200].x(), 5.0);                 // towards +x
  const TriangleMesh rod = make_shape("cylinder", 30.0, 30, 0.1);
  bend.axis = Vector3d::UnitZ();
  bend.length_mm.reset();
  EXPECT_NEAR(enclosed_volume(deformed_by(rod, bend)) / enclosed_volume(rod), 1.0, 1e-3);
}

TEST(Deform, InflateMovesASphereToALargerOne) {
  const TriangleMesh mesh = make_shape("sphere", 20.0, 24);
  for (const Vector3d& vertex : deformed_by(mesh, of(DeformKind::inflate, 1.5)).vertices) {
    EXPECT_NEAR(vertex.norm(), 11.5, 0.03);  // normals of triangles
  }
}

TEST(Deform, ADentPushesInwardsAndABumpOutwards) {
  const TriangleMesh mesh = make_shape("cube", 20.0, 40);
  for (const double amount : {2.0, -2.0}) {
    const Deformation dent = within(of(DeformKind::dent, amount), {1.0, 10.0, -1.0}, 4.0);
    const TriangleMesh moved = deformed_by(mesh, dent);
    double least = 10.0, most = 10.0;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      if (mesh.vertices[v].y() != 10.0) continue;
      EXPECT_LT((moved.vertices[v] - mesh.vertices[v]).head<1>().norm(), 1e-12);
      least = std::min(least, moved.vertices[v].y());
      most = std::max(most, moved.vertices[v].y());
    }
    EXPECT_NEAR(amount > 0.0 ? least : most, 10.0 - amount, 1e-9);
    EXPECT_EQ(amount > 0.0 ? most : least, 10.0);
  }
}

TEST(Deform, ScaleMultipliesTheVolumeByItsFactorOncePerDirection) {
  const TriangleMesh mesh = make_shape("torus", 20.0, 40);
  Deformation scale = of(DeformKind::scale, 1.25);
  EXPECT_NEAR(enclosed_volume(deformed_by(mesh, scale)) / enclosed_volume(mesh), 1.953125, 1e-9);
  scale.axis = Vector3d(1.0, 2.0, -2.0) / 3.0;
  EXPECT_NEAR(enclosed_volume(deformed_by(mesh, scale)) / enclosed_volume(mesh), 1.25, 1e-9);
}

TEST(Deform, NoiseMovesAlongTheNormalByLessThanItsAmountAndFollowsItsOffset) {
  const TriangleMesh mesh = make_shape("sphere", 20.0, 30);
  Deformation noise = of(DeformKind::noise, 1.0);
  noise.wavelength_mm = 5.0;
  const TriangleMesh moved = deformed_by(mesh, noise);
  double most = 0.0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const double by = moved.vertices[v].norm() - 10.0;
    most = std::max(most, std::abs(by));
    EXPECT_LT((moved.vertices[v].normalized() - mesh.vertices[v].normalized()).norm(), 0.01);
  }
  EXPECT_GT(most, 0.3);
  EXPECT_LE(most, 1.0);
  noise.offset_mm = {2.5, 0.0, 0.0};
  EXPECT_GT(apart(moved, deformed_by(mesh, noise)), 0.1);
}

// The edge: a ring of 2.5 mm tube whose neighbouring sides are bent towards each other.
TEST(DeformedBody, RefusesAShapeThatCrossesItselfFromTheEdgeOn) {
  const TriangleMesh rod = make_shape("cylinder", 40.0, 40, 0.125);
  const auto bent = [&](double degrees) {
    Deformation bend = of(DeformKind::bend, degrees);
    bend.axis = Vector3d::UnitZ();
    return deformed_body(rod, std::span(&bend, 1));
  };
  // The ends of a rod 40 mm long meet at 360 degrees; its 5 mm thick middle line has radius 6.4.
  EXPECT_NO_THROW(bent(340.0));
  EXPECT_NO_THROW(bent(-340.0));
  std::vector<Deformation> both{of(DeformKind::scale, 1.1), of(DeformKind::bend, 375.0)};
  both[1].axis = Vector3d::UnitZ();
  EXPECT_THAT(sentence_of([&] { deformed_body(rod, both); }, ""),
              testing::HasSubstr("deform[1], bend of 375 degrees, makes the surface cross itself; "
                                 "reduce its degrees"));
}

TEST(DeformedBody, RefusesWhatTurnsInsideOutAndABrushThatHoldsNothing) {
  const TriangleMesh ball = make_shape("sphere", 20.0, 12);
  const Deformation hollow = of(DeformKind::inflate, -25.0);
  EXPECT_THAT(sentence_of([&] { deformed_body(ball, std::span(&hollow, 1)); }, ""),
              testing::HasSubstr("inflate of -25 mm, turns the surface inside out"));
  const Deformation away = within(of(DeformKind::dent, 1.0), {50.0, 0.0, 0.0}, 5.0);
  EXPECT_THAT(sentence_of([&] { deformed_body(ball, std::span(&away, 1)); }, ""),
              testing::HasSubstr("brush holds no vertex"));
}

}  // namespace
}  // namespace kappamu::render
