// How the weight goes from strong to the noise level, by χ² alone.
#include "inverse/fit/regularisation_path.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kappamu::inverse {
namespace {

constexpr int finest = 0;
constexpr std::optional<Outlook> unknown;
constexpr int coarse = 1;
constexpr NextStep minimise{NextStep::What::minimise};
constexpr NextStep minimise_as_begun{NextStep::What::minimise, NextStep::From::begun};
constexpr NextStep finer_grid{NextStep::What::finer_grid};
constexpr NextStep conclude{NextStep::What::conclude};
constexpr NextStep conclude_as_begun{NextStep::What::conclude, NextStep::From::begun};

/// Where cross-validation expects `score` here, the data fitted having `chi2`.
Outlook scored(double chi2, double score) {
  return {std::sqrt(chi2 / score)};
}

class RegularisationPathTest : public testing::Test {
 protected:
  RegularisationPathTest() {
    options.first_weight = 1000.0;
    options.weight_factor = 0.5;
    options.last_weight = 100.0;
    options.stagnation = 0.1;
    options.stage_tolerance = 1e-3;
    options.final_tolerance = 1e-4;
  }

  PathOptions options;
  FitContext context;
  PathPosition at;
  RegularisationPath path{options, context, at};
};

TEST_F(RegularisationPathTest, StartsAtTheFirstWeightAndByWholeStepsAboveItWhereTheDataAreSharp) {
  path.start(50.0, coarse);
  EXPECT_EQ(at.weight, 1000.0);
  path.start(100.0 * 3.0, coarse);
  EXPECT_EQ(at.weight, 4000.0) << "log2 3, rounded up to two steps";
  EXPECT_EQ(at.phase, FitPhase::descending);
}

TEST_F(RegularisationPathTest, DescendsToTheNoiseThenMinimisesTheLastWeightOnceMore) {
  path.start(50.0, finest);
  EXPECT_EQ(path.tolerance(), 1e-3);
  EXPECT_EQ(path.minimum(9.0, 9.0, unknown, finest), minimise);
  EXPECT_EQ(at.weight, 500.0);
  EXPECT_EQ(path.minimum(0.9, 0.9, unknown, finest), minimise);
  EXPECT_EQ(at.weight, 500.0);
  EXPECT_EQ(at.phase, FitPhase::last_weight);
  EXPECT_EQ(at.end, PathEnd::noise);
  EXPECT_EQ(path.tolerance(), 1e-4);
  EXPECT_EQ(path.minimum(0.8, 0.8, unknown, finest), conclude);
  EXPECT_EQ(at.last_chi2, 0.8);
}

TEST_F(RegularisationPathTest, DescendsByCrossValidationAloneBelowTheNoise) {
  constexpr double left = 0.9;  // 1 − γ/N: what a right variance leaves of χ² per value
  path.start(50.0, finest);
  EXPECT_EQ(path.minimum(0.5, 0.5, Outlook{left, 0.8}, finest), minimise);
  EXPECT_EQ(at.weight, 500.0);
  EXPECT_EQ(at.phase, FitPhase::descending);
  EXPECT_EQ(at.end, PathEnd::unknown);
  EXPECT_EQ(path.minimum(0.4, 0.4, Outlook{left, 1.05}, finest), minimise);
  EXPECT_EQ(at.weight, 500.0) << "no weight is tried where other light would be worse";
  EXPECT_EQ(at.end, PathEnd::validated);
  EXPECT_EQ(at.phase, FitPhase::last_weight);

  path.start(50.0, finest);
  path.minimum(0.92, 0.92, Outlook{left, 0.95}, finest);
  EXPECT_EQ(at.weight, 500.0) << "χ² ≤ 1 is no end by itself";
  EXPECT_EQ(at.phase, FitPhase::descending);
  path.minimum(0.91, 0.91, Outlook{left, 1.05}, finest);
  EXPECT_EQ(at.end, PathEnd::validated);
  options.target_chi2 = 4.0;
  path.start(50.0, finest);
  path.minimum(3.0, 3.0, Outlook{left, 0.5}, finest);
  EXPECT_EQ(at.end, PathEnd::noise) << "a smoother volume was asked for";
}

TEST_F(RegularisationPathTest, EndsWithTheDescentWhereNoMorePatienceIsAskedForOrAnotherFitGoesOn) {
  options.final_tolerance = options.stage_tolerance;
  path.start(50.0, finest);
  EXPECT_EQ(path.minimum(0.9, 0.9, unknown, finest), conclude);
  options.final_tolerance = 0.0;
  path.start(50.0, finest);
  EXPECT_EQ(path.minimum(0.9, 0.9, Outlook{0.9, 1.1, false}, finest), conclude)
      << "what it would explain may be errors that pixels share";
  context.interim = true;
  path.start(50.0, finest);
  EXPECT_EQ(path.minimum(0.9, 0.9, unknown, finest), conclude);
}

TEST_F(RegularisationPathTest, AMinimumThatTheRenewedCorrectionUndoesIsFoundOnceMoreAtItsWeight) {
  path.start(50.0, finest);
  EXPECT_EQ(path.minimum(0.9, 3.0, unknown, finest), minimise);
  EXPECT_EQ(at.phase, FitPhase::descending_again);
  EXPECT_EQ(at.weight, 1000.0);
  EXPECT_EQ(path.minimum(0.9, 3.0, unknown, finest), minimise) << "but not twice";
  EXPECT_EQ(at.phase, FitPhase::descending);
  EXPECT_EQ(at.weight, 500.0);

  at.phase = FitPhase::last_weight;
  EXPECT_EQ(path.minimum(0.9, 3.0, unknown, finest), minimise);
  EXPECT_EQ(at.phase, FitPhase::last_weight_again);
  EXPECT_EQ(path.minimum(0.9, 3.0, unknown, finest), conclude);
}

TEST_F(RegularisationPathTest, AMinimumThatTheRenewedCorrectionTakesFarIsNoneToEndAt) {
  const Outlook outlook{0.9, 1.2};
  path.start(50.0, finest);
  EXPECT_EQ(path.minimum(0.5, 0.95, outlook, finest), minimise);
  EXPECT_EQ(at.phase, FitPhase::descending_again);
  EXPECT_EQ(at.weight, 1000.0);
  EXPECT_EQ(path.minimum(0.5, 0.6, outlook, finest), minimise);
  EXPECT_EQ(at.end, PathEnd::validated);

  path.start(50.0, coarse);
  EXPECT_EQ(path.minimum(0.5, 0.95, unknown, coarse), finer_grid) << "the finer grid sees to it";
}

TEST_F(RegularisationPathTest, StopsAboveTheNoiseWhereLowerWeightsNoLongerHelp) {
  path.start(50.0, finest);
  path.minimum(9.0, 9.0, unknown, finest);
  EXPECT_EQ(path.minimum(8.5, 8.5, unknown, finest), minimise);
  EXPECT_TRUE(path.at_last_weight());
  EXPECT_EQ(at.end, PathEnd::no_gain);
  EXPECT_FALSE(path.at_lowest_weight());
}

TEST_F(RegularisationPathTest, AboveTheNoiseAWeightThatPredictsWorseIsTakenBack) {
  path.start(50.0, finest);
  EXPECT_EQ(path.minimum(9.0, 9.0, scored(9.0, 11.0), finest), minimise);
  EXPECT_EQ(path.minimum(5.0, 5.0, scored(5.0, 12.0), finest), minimise_as_begun);
  EXPECT_EQ(at.weight, 1000.0) << "the one before";
  EXPECT_EQ(at.end, PathEnd::model_error);
  EXPECT_EQ(at.last_chi2, 9.0);
  EXPECT_TRUE(path.at_last_weight());
  EXPECT_FALSE(path.at_lowest_weight());
}

TEST_F(RegularisationPathTest, WhereAnotherFitGoesOnItConcludesWithTheVolumeBefore) {
  context.interim = true;
  path.start(50.0, finest);
  path.minimum(9.0, 9.0, scored(9.0, 11.0), finest);
  EXPECT_EQ(path.minimum(5.0, 5.0, scored(5.0, 12.0), finest), conclude_as_begun);
}

TEST_F(RegularisationPathTest, AtTheNoiseNoScoreTakesAWeightBack) {
  path.start(50.0, finest);
  path.minimum(1.2, 1.2, scored(1.2, 1.3), finest);
  Outlook worse_than_before = scored(0.9, 1.4);
  worse_than_before.next_score = 1.1;
  EXPECT_EQ(path.minimum(0.9, 0.9, worse_than_before, finest), minimise);
  EXPECT_EQ(at.weight, 500.0);
}

TEST_F(RegularisationPathTest, GoesOnWhileAnOctaveIsFurtherOffThanChance) {
  path.start(50.0, finest);
  Outlook outlook{0.9, 1.5};
  outlook.excess = 2.0;
  EXPECT_EQ(path.minimum(0.8, 0.8, outlook, finest), minimise);
  EXPECT_EQ(at.weight, 500.0) << "in spite of a total within the noise and a worse score";
  EXPECT_EQ(at.phase, FitPhase::descending);
  outlook.excess = 0.9;
  path.minimum(0.7, 0.7, outlook, finest);
  EXPECT_EQ(at.weight, 500.0);
  EXPECT_EQ(at.end, PathEnd::validated);
}

TEST_F(RegularisationPathTest, AnOctaveThatNoWeightExplainsDoesNotLeadOn) {
  path.start(50.0, finest);
  Outlook before = scored(0.8, 1.0);
  before.excess = 3.0;
  path.minimum(0.8, 0.8, before, finest);
  Outlook after = scored(0.6, 1.4);
  after.excess = 2.5;
  EXPECT_EQ(path.minimum(0.6, 0.6, after, finest), minimise_as_begun);
  EXPECT_EQ(at.weight, 1000.0);
}

TEST_F(RegularisationPathTest, StopsAtTheLowestWeight) {
  path.start(50.0, finest);
  double chi2 = 50.0;
  while (!path.at_last_weight()) {
    chi2 *= 0.5;
    ASSERT_EQ(path.minimum(chi2, chi2, unknown, finest), minimise);
  }
  EXPECT_EQ(at.weight, 125.0) << "the next, 62.5, is below last_weight";
  EXPECT_TRUE(path.at_lowest_weight());
  EXPECT_EQ(at.end, PathEnd::lowest);
}

TEST_F(RegularisationPathTest, OnACoarseGridKeepsItsWeightThoughTheNoiseIsFar) {
  path.start(50.0, coarse);
  EXPECT_EQ(path.minimum(20.0, 20.0, unknown, coarse), finer_grid);
  path.refine(15.0, finest);
  EXPECT_EQ(at.weight, 1000.0);
  EXPECT_EQ(at.last_chi2, 0.0) << "of another grid";
  EXPECT_EQ(at.phase, FitPhase::descending);
}

TEST_F(RegularisationPathTest, OnAFinerGridGoesOnByWholeStepsAboveWhereTheVolumeIsFarOff) {
  path.start(50.0, coarse);
  EXPECT_EQ(path.minimum(0.5, 0.5, unknown, coarse), finer_grid);
  path.refine(500.0, finest);
  EXPECT_EQ(at.weight, 4000.0);
}

TEST_F(RegularisationPathTest, AFixedWeightIsMinimisedOnceOnEveryGrid) {
  options.weight = 7.0;
  path.start(1e6, coarse);
  EXPECT_EQ(at.weight, 7.0);
  EXPECT_EQ(path.tolerance(), 1e-3);
  EXPECT_EQ(path.minimum(0.5, 30.0, unknown, coarse), finer_grid);
  path.refine(1e6, finest);
  EXPECT_EQ(at.weight, 7.0);
  EXPECT_EQ(path.tolerance(), 1e-4);
  EXPECT_EQ(path.minimum(0.5, 30.0, unknown, finest), conclude);
}

TEST_F(RegularisationPathTest, FromAnotherFitsVolumeItStartsOneWeightAbove) {
  context.continued = Continuation{};
  path.start_from(400.0);
  EXPECT_EQ(at.weight, 800.0);
  path.start_from(10.0);
  EXPECT_EQ(at.weight, 100.0) << "not below last_weight";
  options.weight = 7.0;
  path.start_from(400.0);
  EXPECT_TRUE(path.at_last_weight());
  EXPECT_EQ(at.weight, 7.0);
  EXPECT_EQ(path.minimum(0.5, 3.0, unknown, finest), minimise) << "with r renewed";
  EXPECT_EQ(path.minimum(0.5, 3.0, unknown, finest), conclude);
}

}  // namespace
}  // namespace kappamu::inverse
