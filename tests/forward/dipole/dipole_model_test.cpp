// The models of objects by the dipole: power, laws, limits, and the sentences at their edges.
#include "forward/dipole/dipole_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/mesh/shapes.h"
#include "forward/dipole/profile/profile.h"
#include "forward/registry.h"
#include "tests/forward/embedded/embedded_test_tools.h"

namespace kappamu::forward {
namespace {

constexpr double eta = 1.3;

struct Object {
  explicit Object(TriangleMesh m, const Coefficients& c)
      : mesh(std::move(m)),
        surface(surface_of(mesh)),
        rays(embedded::make_caster(mesh)),
        medium(c) {}

  ObjectResult solve(const std::string& model, const std::vector<ObjectLight>& lights,
                     double tolerance = 0.02) const {
    ObjectOptions options;
    options.tolerance = tolerance;
    Progress progress;
    return make_object_model(model)->solve({mesh, surface, *rays, medium, eta, lights}, options,
                                           progress);
  }

  ObjectLight diffuse() const { return {{}, std::vector<double>(surface.size(), 1.0)}; }
  ObjectLight beam(int triangle, double power = 1.0) const {
    const auto t = static_cast<std::size_t>(triangle);
    return {{{triangle, surface.position[t], -surface.normal[t], power}}, {}};
  }

  TriangleMesh mesh;
  Surface surface;
  std::unique_ptr<RayCaster> rays;
  ObjectMedium medium;
};

/// A sphere of forty mean free paths with absorption: nearly a half-space everywhere.
Object large_sphere(int tessellation = 14) {
  return Object(make_shape("sphere", 40.0, tessellation), {1.0 / 3.0, 0.05});
}

class DipoleModels : public testing::TestWithParam<const char*> {};

TEST_P(DipoleModels, UnderEvenLightALargeObjectReflectsWhatTheHalfSpaceDoes) {
  const Object object = large_sphere();
  const ObjectResult result = object.solve(GetParam(), {object.diffuse()});
  const std::string name = GetParam();
  const double reflectance =
      dipole::make_profile(name.starts_with("dipole") ? "dipole" : name, {1.0 / 3.0, 0.05}, eta)
          .reflectance();
  constexpr double curvature = 0.04;  // of the order of diffusion length over radius, squared
  EXPECT_NEAR(result.balance[0].exiting / result.balance[0].entering / reflectance, 1.0, curvature);
  EXPECT_TRUE(result.converged) << result.message;
  EXPECT_LT(result.error_estimate[0], 0.02);
  EXPECT_NEAR(result.balance[0].entering - result.balance[0].exiting, result.balance[0].absorbed,
              1e-9 * result.balance[0].entering);
}

TEST_P(DipoleModels, AreLinearInTheLight) {
  const Object object = large_sphere(8);
  ObjectLight both = object.diffuse();
  both.beams = object.beam(5, 30.0).beams;
  const ObjectResult r = object.solve(GetParam(), {object.diffuse(), object.beam(5, 30.0), both});
  const std::size_t n = object.surface.size();
  constexpr double single_precision = 1e-5;
  const double size = *std::max_element(r.exitance.begin(), r.exitance.end());
  for (std::size_t t = 0; t < n; ++t) {
    EXPECT_NEAR(r.exitance[t] + r.exitance[n + t], r.exitance[2 * n + t], single_precision * size);
  }
}

TEST_P(DipoleModels, RefuseAMediumThatVaries) {
  const Object object = large_sphere(4);
  const GridShape two{1, 1, 2, 1.0};
  const Medium medium{Volume<double>(two, {0.3, 0.4}), Volume<double>(two, 0.1)};
  Progress progress;
  const ObjectMedium varying(std::make_shared<const Medium>(medium), Eigen::Affine3d::Identity(),
                             Wrap::clamp);
  const std::vector<ObjectLight> lights{object.diffuse()};
  EXPECT_THROW(
      make_object_model(GetParam())
          ->solve({object.mesh, object.surface, *object.rays, varying, eta, lights}, {}, progress),
      InputError);
}

INSTANTIATE_TEST_SUITE_P(All, DipoleModels,
                         testing::Values("dipole", "dipole-rotated", "better-dipole",
                                         "beam-diffusion"));

TEST(DipoleModel, OfRotatedSourcesIsReciprocalAndOfAlignedOnesIsNot) {
  const Object object(make_shape("cube", 6.0, 6), {0.3, 0.02});
  // Two triangles about a corner.
  const auto nearest = [&](const Eigen::Vector3d& place) {
    std::size_t best = 0;
    for (std::size_t t = 0; t < object.surface.size(); ++t) {
      if ((object.surface.position[t] - place).norm() <
          (object.surface.position[best] - place).norm()) {
        best = t;
      }
    }
    return static_cast<int>(best);
  };
  const int a = nearest({3.0, 0.2, 2.6}), b = nearest({1.2, 0.2, 3.0});
  const auto ratio = [&](const std::string& model) {
    const ObjectResult r = object.solve(model, {object.beam(a), object.beam(b)}, 0.01);
    return r.exitance[static_cast<std::size_t>(b)] /
           r.exitance[object.surface.size() + static_cast<std::size_t>(a)];
  };
  EXPECT_NEAR(ratio("dipole-rotated"), 1.0, 0.05);  // a triangle's mean against its centroid
  EXPECT_GT(std::abs(ratio("dipole") - 1.0), 0.15);
}

TEST(DipoleModel, WarnsWhereTheObjectIsTooThin) {
  // [T] 3.6.1's cylinder: marble, radius 12 mm, 2 mm high.
  const Object thin(cylinder_mesh(12.0, 2.0, 40), {1.0 / (3.0 * 2.1921), 0.0021});
  const ObjectResult result = thin.solve("dipole-rotated", {thin.diffuse()});
  EXPECT_GT(result.balance[0].exiting, result.balance[0].entering);
  EXPECT_GT(result.balance[0].created, 0.02 * result.balance[0].entering);
  EXPECT_FALSE(result.converged);
  EXPECT_THAT(result.warnings, testing::Contains(testing::HasSubstr("mean free paths")));
  EXPECT_THAT(result.warnings, testing::Contains(testing::HasSubstr("times the entering power")));
  EXPECT_THAT(large_sphere(8).solve("dipole-rotated", {}).warnings, testing::IsEmpty());
}

TEST(DipoleModel, OfAlignedSourcesWarnsWhereTheyLieBesideTheSurface) {
  // Marble of 24 mean free paths: below the rim of a cylinder, and across a thin ring.
  const Coefficients marble{1.0 / (3.0 * 2.1921), 0.0021};
  const double size = 24.0 * 3.0 * marble.kappa;
  const auto beside = testing::Contains(testing::HasSubstr("lie beside another part"));
  for (const TriangleMesh& mesh :
       {make_shape("cylinder", size, 30), make_shape("torus", size / 12.0, 16)}) {
    const Object object(mesh, marble);
    const ObjectResult aligned = object.solve("dipole", {object.diffuse()});
    const ObjectResult rotated = object.solve("dipole-rotated", {object.diffuse()});
    EXPECT_THAT(aligned.warnings, beside);
    EXPECT_THAT(rotated.warnings, testing::Not(beside));
    double most = 0.0;
    for (std::size_t t = 0; t < object.surface.size(); ++t) {
      most = std::max(most, aligned.exitance[t] / rotated.exitance[t]);
    }
    EXPECT_GT(most, 2.0);
  }
  for (const char* shape : {"sphere", "torus"}) {
    const Object object(make_shape(shape, 40.0, 20), {1.0 / 3.0, 0.05});
    EXPECT_THAT(object.solve("dipole", {object.diffuse()}).warnings, testing::Not(beside));
  }
}

TEST(DipoleModel, WarnsOfVoidsAndGaps) {
  const TriangleMesh ball = make_shape("sphere", 40.0, 10);
  const auto crosses = testing::Contains(testing::HasSubstr("2 separate surfaces"));
  for (const TriangleMesh& other :
       {turned_inside_out(make_shape("sphere", 10.0, 6)), moved(ball, {50.0, 0.0, 0.0})}) {
    const Object object(joined(ball, other), {1.0 / 3.0, 0.05});
    EXPECT_THAT(object.solve("dipole-rotated", {object.diffuse()}).warnings, crosses);
  }
  const Object alone(ball, {1.0 / 3.0, 0.05});
  EXPECT_THAT(alone.solve("dipole-rotated", {alone.diffuse()}).warnings,
              testing::Not(testing::Contains(testing::HasSubstr("voids"))));
}

TEST(DipoleModel, MeetsATighterTolerance) {
  const Object object(make_shape("torus", 12.0, 40), {0.15, 0.003});
  const ObjectResult result = object.solve("dipole-rotated", {object.beam(100)}, 0.004);
  EXPECT_TRUE(result.converged) << result.message;
  EXPECT_GT(result.iterations, 1);
}

TEST(DipoleModel, RefusesABeamFromInside) {
  const Object object = large_sphere(4);
  ObjectLight light = object.beam(0);
  light.beams[0].direction *= -1.0;
  EXPECT_THROW(object.solve("dipole-rotated", {light}), InputError);
}

}  // namespace
}  // namespace kappamu::forward
