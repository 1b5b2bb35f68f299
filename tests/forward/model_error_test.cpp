// What models state of themselves against transport, and where: laws of the map. How true the
// numbers are is measured by `kappamu-studies objects` (docs/objects-bench.md).
#include "forward/model_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/mesh/shapes.h"
#include "core/mesh/surface_norm.h"
#include "forward/registry.h"
#include "tests/forward/choice/lit_object.h"

namespace kappamu::forward {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

/// A cube of ten mean free paths of 0.3 mm, of marble's albedo.
Lit cube() {
  return Lit(make_shape("cube", 3.0, 20), ObjectMedium(Coefficients{0.1, 0.003}));
}

ObjectResult solved(const char* model, const Lit& object, double tolerance = 0.02) {
  ObjectOptions options;
  options.tolerance = tolerance;
  Progress silent;
  return make_walking(model, 2e4)->solve(object.problem(), options, silent);
}

class Diffusing : public testing::TestWithParam<const char*> {};

TEST_P(Diffusing, MapHasTheStatedNormAndIsLargestAtEdges) {
  const Lit object = cube();
  const ObjectProblem problem = object.problem();
  const ObjectResult result = solved(GetParam(), object);
  ASSERT_EQ(result.model_error.size(), 1U);
  EXPECT_GT(result.error(0), 0.03) << "measured: 5 to 12 % between 24 and 8 mean free paths";
  const std::vector<double> map = error_map(problem, result, 0);
  std::vector<double> difference(map.size());
  double edges = 0.0, middles = 0.0;
  int at_edges = 0, at_middles = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    difference[i] = map[i] * result.exitance[i];
    Eigen::Array3d from_middle = problem.surface.position[i].array().abs();
    std::sort(from_middle.begin(), from_middle.end());
    (from_middle[1] > 1.35 ? edges : middles) += map[i];
    ++(from_middle[1] > 1.35 ? at_edges : at_middles);
  }
  const double size = surface_norm(problem.surface, result.exitance);
  EXPECT_NEAR(surface_norm(problem.surface, difference) / size, result.error(0), 1e-9);
  EXPECT_GT(edges / at_edges, 1.2 * middles / at_middles);
  EXPECT_THAT(result.warnings, Contains(HasSubstr("the model itself errs by")));
}

INSTANTIATE_TEST_SUITE_P(Models, Diffusing, testing::Values("embedded", "dipole-rotated"));

TEST(ModelError, OfThickRoundObjectsIsSmallAndWarnsOfNothing) {
  const Lit ball(make_shape("sphere", 12.0, 12), ObjectMedium(Coefficients{0.1, 0.003}));
  const ObjectResult result = solved("embedded", ball);
  EXPECT_LT(result.model_error[0], 0.05);
  EXPECT_THAT(result.warnings, Not(Contains(HasSubstr("itself errs"))));
}

TEST(ModelError, OfRandomWalksIsTheirNoise) {
  const Lit object = cube();
  const ObjectResult result = solved("montecarlo", object);
  EXPECT_THAT(result.model_error, IsEmpty());
  EXPECT_EQ(result.error(0), result.error_estimate[0]);
  const std::vector<double> map = error_map(object.problem(), result, 0);
  const auto brightest = static_cast<std::size_t>(
      std::max_element(result.exitance.begin(), result.exitance.end()) - result.exitance.begin());
  EXPECT_DOUBLE_EQ(map[brightest], result.standard_error[brightest] / result.exitance[brightest]);
}

TEST(ModelError, WhatADipoleCreatesIsStatedAndNotConverged) {
  const Lit thin(make_shape("slab", 8.0, 12, 0.06), ObjectMedium(Coefficients{0.1, 1e-4}));
  const ObjectResult result = solved("dipole-rotated", thin);
  const ObjectBalance& balance = result.balance[0];
  EXPECT_GT(balance.created, 0.02 * balance.entering);
  EXPECT_EQ(balance.absorbed, 0.0);
  EXPECT_NEAR(balance.entering + balance.created, balance.exiting, 1e-9 * balance.exiting);
  EXPECT_GE(result.error(0), balance.created / balance.entering);
  EXPECT_FALSE(result.converged);
}

TEST(ModelError, AutoIsNotConvergedBeyondItsTolerance) {
  const Lit object = cube();
  ObjectOptions asked;
  asked.tolerance = 0.001;
  Progress silent;
  const ObjectResult result = make_walking("auto", 2e4)->solve(object.problem(), asked, silent);
  EXPECT_GT(result.error(0), asked.tolerance);
  EXPECT_FALSE(result.converged);
}

}  // namespace
}  // namespace kappamu::forward
