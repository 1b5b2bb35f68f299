// What model `auto` knows of an object, and what it takes: laws that hold whatever the table says.
#include "forward/choice/choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/mesh/shapes.h"
#include "forward/choice/model_table.h"
#include "forward/registry.h"
#include "tests/forward/choice/lit_object.h"

namespace kappamu::forward {
namespace {

using testing::HasSubstr;

ObjectMedium two_halves(double contrast) {
  const GridShape shape{2, 1, 1, 1.0};
  auto volume =
      std::make_shared<Medium>(Medium{Volume<double>(shape, 0.2), Volume<double>(shape, 0.01)});
  volume->kappa[1] *= contrast;
  return {volume, Eigen::Affine3d::Identity(), Wrap::clamp};
}

TEST(ObjectFeatures, AreWhatGeometrySays) {
  const ObjectMedium medium(Coefficients{0.1, 0.02});  // a mean free path of 0.3 mm
  const ObjectFeatures cube = features_of(Lit(make_shape("cube", 3.0, 8), medium).problem());
  EXPECT_NEAR(cube.size, 10.0, 1e-9);
  EXPECT_NEAR(cube.thickness, 2.0 * 10.0 / 6.0, 1e-9);
  EXPECT_NEAR(cube.albedo, 1.0 - 0.02 * 0.3, 1e-12);
  EXPECT_NEAR(cube.edges, 12.0 * 3.0 * 0.3 / (6.0 * 9.0), 1e-9);
  EXPECT_EQ(cube.patches, 6U * 64U);
  EXPECT_EQ(cube.contrast, 1.0);
  EXPECT_TRUE(cube.block);
  EXPECT_EQ(cube.diffuse, 0.0);
  const double facing = 1.0 + 4.0 + 9.0;  // of a beam along (1, 2, 3), by the power on each face
  EXPECT_NEAR(cube.slant, 1.0 - facing / 6.0 / std::sqrt(14.0), 1e-9);
  const ObjectFeatures ball = features_of(Lit(make_shape("sphere", 3.0, 24), medium).problem());
  EXPECT_NEAR(ball.thickness, 10.0 / 3.0, 0.01 * ball.thickness);
  EXPECT_EQ(ball.edges, 0.0);
  EXPECT_FALSE(ball.block);
  EXPECT_EQ(features_of(Lit(make_shape("cube", 3.0, 8), two_halves(7.0)).problem()).contrast, 7.0);
}

TEST(ObjectFeatures, DoNotDependOnScaleOrTessellation) {
  const auto features = [](double scale, int tessellation) {
    return features_of(Lit(make_shape("cylinder", 4.0 * scale, tessellation),
                           ObjectMedium(Coefficients{0.2 * scale, 0.01 / scale}))
                           .problem());
  };
  const ObjectFeatures one = features(1.0, 24), large = features(1000.0, 24),
                       fine = features(1.0, 48);
  constexpr double rounding = 1e-9, facets = 0.02;
  for (const auto member : {&ObjectFeatures::size, &ObjectFeatures::thickness,
                            &ObjectFeatures::albedo, &ObjectFeatures::edges}) {
    EXPECT_NEAR(large.*member, one.*member, rounding * one.*member);
    EXPECT_NEAR(fine.*member, one.*member, facets * one.*member);
  }
}

ObjectFeatures features(double thickness, double albedo) {
  ObjectFeatures result;
  result.size = 3.0 * thickness;
  result.thickness = thickness;
  result.albedo = albedo;
  result.edges = 0.05;
  result.patches = 192;
  result.triangles = 20'000;
  return result;
}

Choice choice_of(const ObjectFeatures& object, double tolerance, const MachineCosts& costs = {}) {
  ChoiceOptions asked;
  asked.tolerance = tolerance;
  asked.photons = 1ULL << 40;
  asked.costs = costs;
  return choose_model(choosable_models(), {&object, 1}, asked, Remedy::none);
}

const ModelCandidate& candidate(const Choice& choice, const std::string& name) {
  for (const ModelCandidate& c : choice.candidates) {
    if (c.model == name) return c;
  }
  throw std::logic_error(name);
}

TEST(Choice, ExpectsOfAbsorptionWhatDiffusionErrsByUnderAnEvenSkyToo) {
  // A hollow box of chicken, 69 mean free paths: 3.7 % against three million photons.
  ObjectFeatures object = features(10.1, 0.9135);
  object.size = 69.0;
  object.edges = 0.02;
  object.diffuse = 1.0;
  const double absorbing = error_by(measured("embedded").error, object);
  EXPECT_GT(absorbing, 0.025);
  EXPECT_LT(absorbing, 0.05);
  object.albedo = 0.999;
  EXPECT_LT(error_by(measured("embedded").error, object), 0.005);
}

TEST(Choice, PlansPhotonsForTheNoiseThatTheyAreUnlikelyToExceed) {
  for (const double albedo : {0.05, 0.5, 0.99}) {
    const Choice choice = choice_of(features(0.3, albedo), 0.1);
    const double error = candidate(choice, "montecarlo").error.value();
    EXPECT_LT(error, 0.1);
    EXPECT_GT(error, 0.07);
  }
  EXPECT_GT(error_by(measured("montecarlo").error, features(3.0, 0.05)),
            1.1 * error_by(measured("montecarlo").error, features(3.0, 0.75)));
}

TEST(Choice, IsTheCheapestWithinTheToleranceAndNeverDearerForALooserOne) {
  for (const double thickness : {1.5, 5.0, 20.0}) {
    for (const double albedo : {0.8, 0.97, 0.999}) {
      std::optional<double> last;
      for (const double tolerance : {0.01, 0.03, 0.1, 0.3}) {
        const Choice choice = choice_of(features(thickness, albedo), tolerance);
        const ModelCandidate& taken = choice.candidates.front();
        ASSERT_TRUE(choice.within_tolerance);  // random walks always can
        EXPECT_LE(taken.error.value(), tolerance);
        for (const ModelCandidate& other : choice.candidates) {
          if (other.error && *other.error <= tolerance) {
            EXPECT_LE(taken.seconds.value(), other.seconds.value());
          }
        }
        if (last) {
          EXPECT_LE(taken.seconds.value(), *last);
        }
        last = taken.seconds;
      }
    }
  }
}

TEST(Choice, HasEveryModelOnceWithAReason) {
  std::map<std::string, int> seen;
  for (const ModelCandidate& c : choice_of(features(5.0, 0.99), 0.1).candidates) {
    ++seen[c.model];
    EXPECT_FALSE(c.reason.empty()) << c.model;
  }
  EXPECT_EQ(seen.size(), object_model_names().size());
  for (const auto& [name, times] : seen) {
    EXPECT_EQ(times, 1) << name;
    EXPECT_THAT(object_model_names(), testing::Contains(name));
  }
}

TEST(Choice, LeavesOutWhatCannotAnswer) {
  ObjectFeatures mixed = features(5.0, 0.99);
  mixed.contrast = 2.0;
  const Choice choice = choice_of(mixed, 0.2);
  EXPECT_FALSE(candidate(choice, "dipole-rotated").error);
  EXPECT_THAT(candidate(choice, "dipole-rotated").reason, HasSubstr("not the same everywhere"));
  EXPECT_THAT(candidate(choice, "grid").reason, HasSubstr("no box"));
  EXPECT_TRUE(candidate(choice, "embedded").error);
  // Where nothing was measured only transport is known to be right.
  const Choice dark = choice_of(features(5.0, 0.2), 0.2);
  EXPECT_EQ(dark.candidates.front().model, "montecarlo");
  EXPECT_THAT(candidate(dark, "embedded").reason, HasSubstr("albedo"));
  const Choice thin = choice_of(features(0.1, 0.99), 0.2);
  EXPECT_EQ(thin.candidates.front().model, "montecarlo");
  EXPECT_THAT(candidate(thin, "embedded").reason, HasSubstr("thin"));
  ChoiceOptions asked;
  asked.tolerance = 0.2;
  asked.follow_reentry = true;
  const ObjectFeatures usual = features(5.0, 0.99);
  EXPECT_THAT(candidate(choose_model(choosable_models(), {&usual, 1}, asked, Remedy::none),
                        "dipole-rotated")
                  .reason,
              HasSubstr("again"));
}

TEST(Choice, FollowsTheCostsOfThisMachine) {
  const ObjectFeatures thick = features(20.0, 0.98);
  const Choice usual = choice_of(thick, 0.3);
  ASSERT_TRUE(usual.candidates[1].error && *usual.candidates[1].error <= 0.3);
  const Choice other = choice_of(thick, 0.3, {{usual.candidates[0].model, 1e4}});
  EXPECT_EQ(other.candidates[0].model, usual.candidates[1].model);
}

TEST(Choice, AsksTheWorstChannel) {
  const std::vector<ObjectFeatures> channels{features(20.0, 0.999), features(2.0, 0.8)};
  ChoiceOptions asked;
  asked.tolerance = 0.1;
  const double both =
      candidate(choose_model(choosable_models(), channels, asked, Remedy::none), "embedded")
          .error.value();
  EXPECT_EQ(both, candidate(choice_of(channels[1], 0.1), "embedded").error.value());
  EXPECT_GT(both, candidate(choice_of(channels[0], 0.1), "embedded").error.value());
}

TEST(Choice, PhotonsGrowWithTheToleranceSquared) {
  const ObjectFeatures object = features(5.0, 0.99);
  const auto photons = [&](double tolerance) {
    ChoiceOptions asked;
    asked.tolerance = tolerance;
    asked.photons = 1ULL << 40;
    return static_cast<double>(options_for(transport_model(), {&object, 1}, asked).photons);
  };
  EXPECT_NEAR(photons(0.005) / photons(0.01), 4.0, 1e-3);
}

/// Absorbs so strongly that only random walks are known to be right.
ObjectMedium dark() {
  return ObjectMedium(Coefficients{0.2, 0.9});
}

std::unique_ptr<ObjectModel> made(const ChoiceOptions& asked) {
  return make_walking("auto", static_cast<double>(asked.photons));
}

TEST(AutoModel, IsTheModelItTakes) {
  const Lit ball(make_shape("sphere", 5.0, 12), ObjectMedium(Coefficients{0.1, 0.01}));
  ChoiceOptions asked;
  asked.tolerance = 0.5;
  Progress silent;
  const ObjectResult result = made(asked)->solve(ball.problem(), asked, silent);
  ASSERT_EQ(result.candidates.size(), choosable_models().size());
  const std::string& taken = result.candidates.front().model;
  EXPECT_THAT(result.candidates.front().reason, HasSubstr("cheapest"));
  const ObjectFeatures object = features_of(ball.problem());
  const ChoiceOptions own = options_for(object_model(taken), {&object, 1}, asked);
  const ObjectResult same =
      make_chosen(object_model(taken), own)->solve(ball.problem(), own, silent);
  EXPECT_EQ(result.exitance, same.exitance);
  EXPECT_TRUE(same.candidates.empty());
}

TEST(AutoModel, PassesOverModelsThatRefuse) {
  const Lit ball(make_shape("sphere", 5.0, 12), ObjectMedium(Coefficients{0.1, 0.01}));
  ChoiceOptions asked;
  asked.tolerance = 0.2;
  asked.max_elements = 10;  // fewer than any surface has; photons do not count
  Progress silent;
  const ObjectResult result = made(asked)->solve(ball.problem(), asked, silent);
  EXPECT_EQ(result.candidates.front().model, "montecarlo");
  EXPECT_THAT(result.candidates,
              testing::Contains(testing::Field(&ModelCandidate::reason, HasSubstr("refused: "))));
}

TEST(AutoModel, WalksThePhotonsThatTheToleranceNeeds) {
  const Lit ball(make_shape("sphere", 5.0, 16), dark());
  ChoiceOptions asked;
  asked.tolerance = 0.2;
  asked.photons = 1 << 30;
  Progress silent;
  const ObjectResult result = made(asked)->solve(ball.problem(), asked, silent);
  ASSERT_EQ(result.candidates.front().model, "montecarlo");
  // The table's law of noise, on an object far from those it was made from.
  EXPECT_LT(result.error_estimate[0], asked.tolerance);
  EXPECT_GT(result.error_estimate[0], 0.3 * asked.tolerance);
  asked.photons = 30'000;
  asked.tolerance = 0.01;
  const ObjectResult few = made(asked)->solve(ball.problem(), asked, silent);
  EXPECT_EQ(few.elements, 30'000U);
  EXPECT_FALSE(few.converged);
  EXPECT_THAT(few.warnings, testing::Contains(HasSubstr("no model is known")));
}

}  // namespace
}  // namespace kappamu::forward
