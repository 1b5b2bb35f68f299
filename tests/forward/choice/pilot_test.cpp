// Answers that pilots corrected, against long walks.
#include "forward/choice/pilot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/mesh/shapes.h"
#include "forward/patches.h"
#include "forward/registry.h"
#include "tests/forward/choice/lit_object.h"

namespace kappamu::forward {
namespace {

using testing::HasSubstr;

/// A tolerance that a pilot meets by its correction, near the error expected of model embedded.
struct Piloted {
  Piloted(const char* shape, double size_mm, const Coefficients& medium, double part = 1.2)
      : object(make_shape(shape, size_mm, 20), ObjectMedium(medium)),
        features(features_of(object.problem())) {
    asked.tolerance = part * error_by(measured("embedded").error, features);
    asked.photons = 1ULL << 31;
    choice = choose_model(choosable_models(), {&features, 1}, asked, Remedy::walks);
    const ObjectProblem problem = object.problem();
    pilot = run_pilot({&problem, 1}, {&features, 1}, asked, choice, silent);
  }
  Lit object;
  ObjectFeatures features;
  ChoiceOptions asked;
  Choice choice;
  Progress silent;
  std::optional<Pilot> pilot;
};

/// Against a walk so long that its noise is below what is asserted.
double error_by_a_long_walk(const Piloted& piloted, const std::vector<double>& exitance) {
  const ObjectProblem problem = piloted.object.problem();
  const Patches patches = make_patches(problem.surface, bounding_box(problem.mesh), patches_across);
  ObjectOptions options;
  options.seed = 77;
  Progress silent;
  const ObjectResult walk = make_walking("montecarlo", 6e5)->solve(problem, options, silent);
  const std::vector<double> mean = patches.mean(exitance, problem.surface);
  const std::vector<double> walked = patches.mean(walk.exitance, problem.surface);
  const std::vector<double> noise =
      patches.error_of_mean(walk.exitance, walk.standard_error, problem.surface);
  double difference = 0.0, size = 0.0;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    difference += patches.area[p] * (std::pow(mean[p] - walked[p], 2) - noise[p] * noise[p]);
    size += patches.area[p] * walked[p] * walked[p];
  }
  return std::sqrt(std::max(0.0, difference / size));
}

class Pilots : public testing::TestWithParam<const char*> {};

TEST_P(Pilots, AnswerWithinTheTolerance) {
  const Piloted piloted(GetParam(), 3.0, {0.1, 0.4});
  ASSERT_TRUE(piloted.pilot.has_value() && piloted.pilot->within);
  const Pilot& pilot = *piloted.pilot;
  const ObjectResult& corrected = pilot.results.front();
  EXPECT_LE(pilot.left, piloted.asked.tolerance);
  EXPECT_LT(error_by_a_long_walk(piloted, corrected.exitance), piloted.asked.tolerance);
  const ModelCandidate& first = piloted.choice.candidates.front();
  EXPECT_EQ(first.model, pilot.model);
  EXPECT_EQ(first.photons, static_cast<double>(pilot.photons));
  EXPECT_THAT(first.reason, HasSubstr("corrected by"));
  // The walk's balance is the answer's.
  const Surface& surface = piloted.object.problem().surface;
  double exiting = 0.0;
  for (std::size_t i = 0; i < surface.size(); ++i)
    exiting += surface.area[i] * corrected.exitance[i];
  const ObjectBalance& balance = corrected.balance.front();
  EXPECT_NEAR(exiting, balance.exiting, 1e-6 * exiting);
  EXPECT_NEAR(balance.exiting + balance.absorbed + balance.unscattered, balance.entering,
              1e-6 * balance.entering);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Pilots, testing::Values("sphere", "torus", "cube"));

TEST(Pilot, IsNotAskedWhereALawIsSure) {
  const Piloted ball("sphere", 3.0, {0.1, 0.4}, 10.0);
  EXPECT_FALSE(ball.pilot.has_value());
  EXPECT_TRUE(ball.choice.within_tolerance);
}

TEST(Pilot, AnswersForModelAuto) {
  const Piloted ball("sphere", 3.0, {0.1, 0.4});
  ASSERT_TRUE(ball.pilot.has_value() && ball.pilot->within);
  Progress silent;
  const auto made = make_walking("auto", static_cast<double>(ball.asked.photons));
  const ObjectResult result = made->solve(ball.object.problem(), ball.asked, silent);
  EXPECT_EQ(result.exitance, ball.pilot->results.front().exitance);
  EXPECT_EQ(result.candidates.front().model, ball.pilot->model);
  EXPECT_THAT(result.warnings, testing::Each(testing::Not(HasSubstr("no model is known"))));
}

}  // namespace
}  // namespace kappamu::forward
