// How the weight goes from strong to the noise level, by χ² and cross-validation alone.
#include "inverse/fit/path_rules.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kappamu::inverse {
namespace {

constexpr std::optional<Outlook> unknown;
constexpr double left = 0.9;  // 1 − γ/N: what a right variance leaves of χ² per value

/// Where cross-validation expects `score` here, the data fitted having `chi2`.
Outlook scored(double chi2, double score) {
  return {std::sqrt(chi2 / score)};
}

class PathRules : public testing::Test {
 protected:
  PathRules() {
    options.first_weight = 1000.0;
    options.weight_factor = 0.5;
    options.last_weight = 100.0;
    options.stage_tolerance = 1e-3;
    options.final_tolerance = 1e-4;
  }
  /// At the first weight unless another is given.
  PathEnd end(double chi2, const std::optional<Outlook>& outlook, double score_before = 0.0,
              double weight = 1000.0) const {
    return end_of_path(options, weight, {chi2, chi2}, outlook, score_before);
  }
  PathOptions options;
};

TEST_F(PathRules, StartsAtTheFirstWeightAndByWholeStepsAboveItWhereTheDataAreSharp) {
  EXPECT_EQ(first_weight(options, 50.0), 1000.0);
  EXPECT_EQ(first_weight(options, 100.0 * 3.0), 4000.0) << "log2 3, rounded up to two steps";
  EXPECT_EQ(weight_on_finer_grid(options, 1000.0, 15.0), 1000.0);
  EXPECT_EQ(weight_on_finer_grid(options, 1000.0, 500.0), 4000.0) << "the volume is far off there";
  EXPECT_EQ(weight_going_on(options, 400.0), 800.0);
  EXPECT_EQ(weight_going_on(options, 10.0), 100.0) << "not below last_weight";
  options.weight = 7.0;
  EXPECT_EQ(first_weight(options, 1e6), 7.0);
  EXPECT_EQ(weight_on_finer_grid(options, 7.0, 1e6), 7.0);
  EXPECT_EQ(weight_going_on(options, 400.0), 7.0);
}

TEST_F(PathRules, EndsAtTheNoiseAndBelowItByCrossValidation) {
  EXPECT_EQ(end(9.0, unknown), PathEnd::unknown);
  EXPECT_EQ(end(0.9, unknown, 0.0, 500.0), PathEnd::noise);
  EXPECT_EQ(end(0.5, Outlook{left, 0.8}), PathEnd::unknown) << "χ² ≤ 1 is no end by itself";
  EXPECT_EQ(end(0.4, Outlook{left, 1.05}, 0.6), PathEnd::validated)
      << "no weight is tried where other light would be worse";
  options.target_chi2 = 4.0;
  EXPECT_EQ(end(3.0, Outlook{left, 0.5}), PathEnd::noise) << "a smoother volume was asked for";
}

TEST_F(PathRules, AMinimumThatTheRenewedCorrectionRevertsIsNone) {
  EXPECT_TRUE(is_reverted(options, {0.9, 3.0}, true));
  EXPECT_TRUE(is_reverted(options, {0.5, 0.95}, true));
  EXPECT_FALSE(is_reverted(options, {0.5, 0.6}, true));
  EXPECT_FALSE(is_reverted(options, {0.5, 0.95}, false)) << "the finer grid sees to it";
  EXPECT_FALSE(is_reverted(options, {3.0, 9.0}, true)) << "the noise was not reached";
}

TEST_F(PathRules, AboveTheNoiseGoesOnToTheLowestWeight) {
  EXPECT_EQ(end(8.0, unknown), PathEnd::unknown);
  EXPECT_EQ(end(8.0, unknown, 0.0, 125.0), PathEnd::lowest)
      << "the next, 62.5, is below last_weight";
}

TEST_F(PathRules, AboveTheNoiseAWeightThatPredictsWorseIsReverted) {
  EXPECT_EQ(end(5.0, scored(5.0, 12.0), 11.0), PathEnd::model_error);
  EXPECT_EQ(end(5.0, scored(5.0, 10.0), 11.0), PathEnd::unknown);
  Outlook worse_than_before = scored(0.9, 1.4);
  worse_than_before.next_score = 1.1;
  EXPECT_EQ(end(0.9, worse_than_before, 1.3), PathEnd::validated)
      << "at the noise no score takes a weight back";
}

TEST_F(PathRules, GoesOnWhileAnOctaveIsFurtherOffThanChance) {
  Outlook outlook{left, 1.5};
  outlook.excess = 2.0;
  EXPECT_EQ(end(0.8, outlook), PathEnd::unknown)
      << "in spite of a total within the noise and a worse score";
  outlook.excess = 0.9;
  EXPECT_EQ(end(0.7, outlook, 1.0), PathEnd::validated);
  Outlook unexplained = scored(0.6, 1.4);
  unexplained.excess = 2.5;
  EXPECT_EQ(end(0.6, unexplained, 1.0), PathEnd::model_error)
      << "an octave that no weight explains does not lead on";
}

TEST_F(PathRules, TheTighterEndIsForTheLastWeightWhereItIsAskedForAndGains) {
  EXPECT_EQ(tolerance(options, false), 1e-3);
  EXPECT_EQ(tolerance(options, true), 1e-4);
  EXPECT_TRUE(needs_tighter_end(options, unknown));
  EXPECT_FALSE(needs_tighter_end(options, Outlook{left, 1.1, false}))
      << "what it would explain may be errors that pixels share";
  options.final_tolerance = options.stage_tolerance;
  EXPECT_FALSE(needs_tighter_end(options, unknown));
}

TEST_F(PathRules, AFixedWeightEndsItsPath) {
  options.weight = 7.0;
  EXPECT_EQ(end(30.0, scored(30.0, 40.0), 35.0, 7.0), PathEnd::asked);
}

}  // namespace
}  // namespace kappamu::inverse
