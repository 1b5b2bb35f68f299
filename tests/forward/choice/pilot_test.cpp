// A pilot's belief in an error, and its decisions against long walks.
#include "forward/choice/pilot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/mesh/shapes.h"
#include "forward/choice/auto_model.h"
#include "forward/choice/patches.h"
#include "forward/object_models.h"
#include "tests/forward/choice/lit_object.h"

namespace kappamu::forward {
namespace {

using testing::HasSubstr;

TEST(ErrorBelief, IsTheLawWithoutAMeasurementAndTheMeasurementWhereItIsSharp) {
  EXPECT_NEAR(probability_below({0.05, 0.3}, 0.05), 0.5, 1e-12);
  EXPECT_NEAR(probability_below({0.05, 0.3}, 0.05 * std::exp(0.3 * 1.2816)), 0.9, 1e-4);
  // So vague a measurement changes nothing, and so sharp a one everything.
  EXPECT_NEAR(probability_below({0.05, 0.3, 0.0, 10.0}, 0.06), probability_below({0.05, 0.3}, 0.06),
              1e-3);
  EXPECT_GT(probability_below({0.05, 0.3, 0.04 * 0.04, 1e-6}, 0.045), 0.999);
  EXPECT_LT(probability_below({0.05, 0.3, 0.06 * 0.06, 1e-6}, 0.055), 0.001);
  EXPECT_GT(probability_below({0.05, 0.3, 0.003, 0.001}, 0.06),
            probability_below({0.05, 0.3, 0.003, 0.001}, 0.05));
  double last = 0.0;
  for (double bound = 0.02; bound < 0.12; bound += 0.01) {
    const double probability = probability_below({0.05, 0.3, 0.003, 0.001}, bound);
    EXPECT_GE(probability, last);
    last = probability;
  }
}

/// What a pilot makes of model embedded where the law alone leaves it open whether it is within the
/// tolerance.
struct Piloted {
  Piloted(const char* shape, double size_mm, const Coefficients& medium)
      : object(make_shape(shape, size_mm, 20), ObjectMedium(medium)),
        features(features_of(object.problem())) {
    for (const MeasuredModel& model : measured_models()) {
      if (model.name == "embedded") asked.tolerance = 1.1 * error_by(model.error, features);
    }
    asked.photons = 1ULL << 31;
    choice = choose_model({&features, 1}, asked, {});
    const ObjectProblem problem = object.problem();
    first = choice.candidates.front().model;
    pilot = run_pilot({&problem, 1}, {&features, 1}, asked, {}, choice, silent);
  }
  Lit object;
  ObjectFeatures features;
  ObjectOptions asked;
  Choice choice;
  std::string first;
  Progress silent;
  std::optional<Pilot> pilot;
};

/// Error of the pilot's model against a walk so long that its noise is below what is asserted.
double error_by_a_long_walk(const Piloted& piloted) {
  const ObjectProblem problem = piloted.object.problem();
  const Patches patches = make_patches(problem.surface, bounding_box(problem.mesh), patches_across);
  ObjectOptions options;
  options.photons = 600'000;
  options.seed = 77;
  Progress silent;
  const ObjectResult walk = make_object_model("montecarlo")->solve(problem, options, silent);
  const std::vector<double> mean =
      patches.mean(piloted.pilot->results.front().exitance, problem.surface);
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

TEST_P(Pilots, DecideAsALongWalkDoes) {
  const Piloted piloted(GetParam(), 3.0, {0.1, 0.4});
  EXPECT_EQ(piloted.first, "montecarlo");
  ASSERT_TRUE(piloted.pilot.has_value());
  const Pilot& pilot = *piloted.pilot;
  const double tolerance = piloted.asked.tolerance, error = error_by_a_long_walk(piloted);
  constexpr double deviations = 3.5;
  EXPECT_NEAR(pilot.belief.square, error * error, deviations * pilot.belief.square_deviation);
  EXPECT_LT(pilot.belief.square_deviation, 0.5 * tolerance * tolerance);
  if (pilot.within) {
    EXPECT_LT(error, 1.1 * tolerance);
  }
  if (pilot.probability < 0.1) {
    EXPECT_GT(error, 0.9 * tolerance);
  }
  const std::vector<ModelCandidate>& candidates = piloted.choice.candidates;
  EXPECT_EQ(candidates.front().model, pilot.within ? pilot.model : "montecarlo");
  const auto asked = std::find_if(candidates.begin(), candidates.end(),
                                  [&](const ModelCandidate& c) { return c.model == pilot.model; });
  EXPECT_THAT(asked->reason, HasSubstr("a pilot of"));
}

INSTANTIATE_TEST_SUITE_P(Shapes, Pilots, testing::Values("sphere", "torus", "cube"));

TEST(Pilot, AnswersForModelAuto) {
  const Piloted ball("sphere", 3.0, {0.1, 0.4});
  ASSERT_TRUE(ball.pilot.has_value() && ball.pilot->within)
      << ball.pilot->error() << " of " << ball.asked.tolerance;
  Progress silent;
  const ObjectResult result = make_auto_model({})->solve(ball.object.problem(), ball.asked, silent);
  EXPECT_EQ(result.exitance, ball.pilot->results.front().exitance);
  EXPECT_EQ(result.candidates.front().model, ball.pilot->model);
  EXPECT_THAT(result.warnings, testing::Each(testing::Not(HasSubstr("no model is expected"))));
}

}  // namespace
}  // namespace kappamu::forward
