// The model from lights to exitance: against `embedded`, which discretises the volume, its own
// error estimate, and what it refuses. Orders: boundary_order_test.
#include "forward/boundary_integral/boundary_integral_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "forward/embedded/embedded_model.h"
#include "tests/forward/embedded/embedded_test_tools.h"
#include "tests/forward/lit_object.h"
#include "tests/sentence.h"

namespace kappamu::forward::boundary_integral {
namespace {

using embedded::box;
using embedded::icosphere;
using embedded::joined;
using embedded::make_caster;
using embedded::transformed;

constexpr double eta = 1.3;
const Coefficients wax{0.3, 0.01};

ObjectResult solve_object(ObjectModel&& model, const TriangleMesh& mesh, const Coefficients& medium,
                          const std::vector<ObjectLight>& lights, double tolerance) {
  const Surface surface = surface_of(mesh);
  const auto rays = make_caster(mesh);
  Progress progress;
  ObjectOptions options;
  options.tolerance = tolerance;
  return model.solve({mesh, surface, *rays, ObjectMedium(medium), eta, lights}, options, progress);
}

double relative_difference(const TriangleMesh& mesh, const std::vector<double>& a,
                           const std::vector<double>& b) {
  const Surface surface = surface_of(mesh);
  double difference = 0.0, size = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    difference += surface.area[t] * std::pow(a[t] - b[t], 2);
    size += surface.area[t] * b[t] * b[t];
  }
  return std::sqrt(difference / size);
}

/// Both models within their stated errors of each other, and powers alike.
void expect_agreement(const TriangleMesh& mesh, const Coefficients& medium,
                      const ObjectLight& light, double tolerance) {
  const ObjectResult ours = solve_object(BoundaryIntegralModel(), mesh, medium, {light}, tolerance);
  const ObjectResult theirs = solve_object(EmbeddedModel(), mesh, medium, {light}, tolerance);
  EXPECT_TRUE(ours.converged) << ours.message;
  EXPECT_LE(relative_difference(mesh, ours.exitance, theirs.exitance),
            ours.error_estimate[0] + theirs.error_estimate[0]);
  const ObjectBalance &a = ours.balance[0], &b = theirs.balance[0];
  EXPECT_NEAR(a.entering, b.entering, 1e-9 * b.entering);
  EXPECT_NEAR(a.unscattered, b.unscattered, 1e-6 * b.entering);
  EXPECT_NEAR(a.exiting, b.exiting, tolerance * b.entering);
  EXPECT_NEAR(a.absorbed, b.absorbed, tolerance * b.entering);
}

TEST(BoundaryIntegralModel, AgreesWithEmbeddedOnASphereUnderSkyAndSun) {
  const TriangleMesh mesh = icosphere(3.0, 3, {0.1, 0.2, 0.3});
  expect_agreement(mesh, wax, sky(mesh), 0.01);
  expect_agreement(mesh, wax, sun(mesh), 0.01);
}

TEST(BoundaryIntegralModel, AgreesWithEmbeddedOnEdgesAndCorners) {
  const TriangleMesh mesh = box({4.0, 3.0, 2.0}, 8);
  expect_agreement(mesh, wax, sky(mesh), 0.01);
  expect_agreement(mesh, wax, sun(mesh), 0.02);
}

TEST(BoundaryIntegralModel, AgreesWithEmbeddedWhereLightPassesUnscattered) {
  const TriangleMesh mesh = icosphere(1.0, 3, {0.0, 0.0, 0.0});
  expect_agreement(mesh, {1.0, 0.05}, sun(mesh), 0.01);
}

TEST(BoundaryIntegralModel, AgreesWithEmbeddedAroundAVoid) {
  const TriangleMesh mesh = joined(
      box({4.0, 4.0, 4.0}, 8),
      transformed(box({2.0, 2.0, 1.0}, 4), Eigen::Affine3d(Eigen::Translation3d(1.0, 1.0, 1.5))),
      true);
  ObjectLight light = sky(mesh);
  std::fill(light.diffuse.begin() + 12 * 64, light.diffuse.end(), 0.0);  // dark in there
  expect_agreement(mesh, wax, light, 0.01);
}

TEST(BoundaryIntegralModel, BodiesAcrossAGapDoNotExchangeLight) {
  const TriangleMesh one = box({2.0, 2.0, 2.0}, 4);
  const TriangleMesh both =
      joined(one, transformed(one, Eigen::Affine3d(Eigen::Translation3d(2.001, 0.0, 0.0))));
  ObjectLight light = sky(one);
  const ObjectResult alone = solve_object(BoundaryIntegralModel(), one, wax, {light}, 0.05);
  light.diffuse.resize(both.triangles.size(), 0.0);
  const ObjectResult together = solve_object(BoundaryIntegralModel(), both, wax, {light}, 0.05);
  for (std::size_t t = 0; t < one.triangles.size(); ++t) {
    ASSERT_NEAR(together.exitance[t], alone.exitance[t], 1e-9);
    ASSERT_EQ(together.exitance[one.triangles.size() + t], 0.0);
  }
}

TEST(BoundaryIntegralModel, WithoutAbsorptionAllLeaves) {
  // What is absorbed is what the equations leave over: their error, where nothing absorbs.
  const TriangleMesh mesh = box({3.0, 3.0, 1.0}, 6);
  const ObjectResult result =
      solve_object(BoundaryIntegralModel(), mesh, {0.2, 0.0}, {sky(mesh), sun(mesh)}, 0.02);
  for (std::size_t l = 0; l < 2; ++l) {
    EXPECT_LE(std::abs(result.balance[l].absorbed),
              result.error_estimate[l] * result.balance[l].entering);
  }
}

TEST(BoundaryIntegralModel, StatesItsErrorUnderAPatchOfLight) {
  const TriangleMesh mesh = icosphere(3.0, 2, {0.1, 0.2, 0.3});
  ObjectLight patch;
  for (const Eigen::Vector3d& normal : surface_of(mesh).normal) {
    patch.diffuse.push_back(normal.z() > 0.8 ? 1.0 : 0.0);
  }
  const Coefficients medium{0.1, 0.05};
  const ObjectResult coarse = solve_object(BoundaryIntegralModel(), mesh, medium, {patch}, 0.1);
  const ObjectResult fine = solve_object(BoundaryIntegralModel(), mesh, medium, {patch}, 0.02);
  EXPECT_TRUE(fine.converged) << fine.message;
  EXPECT_LE(relative_difference(mesh, coarse.exitance, fine.exitance),
            coarse.error_estimate[0] + fine.error_estimate[0]);
}

TEST(BoundaryIntegralModel, LargeBesideSmallTrianglesAndSliversStayWithinTheError) {
  // A box of twelve triangles is the same body as one of many; so is one with a face in slivers
  // whose height is 1/400 of their length.
  const TriangleMesh fine = box({4.0, 4.0, 2.0}, 8), coarse = box({4.0, 4.0, 2.0}, 1);
  TriangleMesh slivers = coarse;
  const int a = slivers.triangles.back()[0], b = slivers.triangles.back()[1],
            c = slivers.triangles.back()[2];
  // A vertex 0.01 mm inside the last triangle's edge from a to b.
  const auto at = [&](int v) { return slivers.vertices[static_cast<std::size_t>(v)]; };
  const Eigen::Vector3d middle = 0.5 * (at(a) + at(b));
  const int v = static_cast<int>(slivers.vertices.size());
  slivers.vertices.push_back(middle + 0.01 * (at(c) - middle).normalized());
  slivers.triangles.back() = {a, b, v};
  slivers.triangles.push_back({b, c, v});
  slivers.triangles.push_back({c, a, v});
  const auto exiting = [](const TriangleMesh& mesh) {
    return solve_object(BoundaryIntegralModel(), mesh, wax, {sky(mesh)}, 0.02).balance[0].exiting;
  };
  const double exact = exiting(fine);
  EXPECT_NEAR(exiting(coarse), exact, 0.02 * exact);
  EXPECT_NEAR(exiting(slivers), exact, 0.02 * exact);
}

std::string refusal(const TriangleMesh& asked, const ObjectMedium& medium,
                    std::optional<std::uint64_t> most = std::nullopt) {
  const Surface surface = surface_of(asked);
  const auto rays = make_caster(asked);
  const std::vector<ObjectLight> lights{sky(asked)};
  Progress progress;
  ObjectOptions options;
  options.max_elements = most;
  return sentence_of([&] {
    BoundaryIntegralModel().solve({asked, surface, *rays, medium, eta, lights}, options, progress);
  });
}

TEST(BoundaryIntegralModel, RefusesInOneSentence) {
  const TriangleMesh mesh = box({2.0, 2.0, 2.0}, 2);
  const ObjectMedium medium(wax);
  EXPECT_THAT(refusal(mesh, medium, 10), testing::HasSubstr("10 are allowed; raise max_elements"));
  TriangleMesh thin = mesh;
  const auto [a, b, c] = thin.triangles[7];
  const int v = static_cast<int>(thin.vertices.size());
  const auto at = [&](int k) { return thin.vertices[static_cast<std::size_t>(k)]; };
  thin.vertices.push_back(0.5 * (at(a) + at(b)) + 1e-5 * (at(c) - at(a)));
  thin.triangles[7] = {a, b, v};
  thin.triangles.push_back({b, c, v});
  thin.triangles.push_back({c, a, v});
  EXPECT_THAT(refusal(thin, medium), testing::HasSubstr("triangle 7 of the mesh is a sliver"));
  auto volume = std::make_shared<Medium>();
  volume->kappa = Volume<double>({2, 2, 2, 1.0}, 0.3);
  volume->mu = Volume<double>({2, 2, 2, 1.0}, 0.01);
  EXPECT_THAT(refusal(mesh, ObjectMedium(volume, Eigen::Affine3d::Identity(), Wrap::clamp)),
              testing::HasSubstr("use model embedded for a measured volume"));
}

}  // namespace
}  // namespace kappamu::forward::boundary_integral
