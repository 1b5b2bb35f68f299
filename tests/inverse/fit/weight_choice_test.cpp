// Rules that pick a weight from a path, on paths whose answer is plain to see.
#include "inverse/fit/weight_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kappamu::inverse {
namespace {

/// χ² falls as the weight until `floor`, R rises slowly before the corner and steeply after it.
std::vector<PathPoint> l_shaped(int points, int corner) {
  std::vector<PathPoint> path;
  for (int k = 0; k < points; ++k) {
    PathPoint p;
    p.weight = std::pow(0.3, k);
    p.chi2 = k <= corner ? std::pow(0.3, k) : std::pow(0.3, corner) * std::pow(0.98, k - corner);
    p.roughness =
        k <= corner ? std::pow(1.1, k) : std::pow(1.1, corner) * std::pow(4.0, k - corner);
    path.push_back(p);
  }
  return path;
}

TEST(WeightChoice, LCurveFindsTheCornerOnceItIsPassed) {
  for (int points = 1; points <= 7; ++points) {
    const WeightDecision decision = choose_weight(WeightRule::l_curve, l_shaped(points, 3), 0.01);
    EXPECT_EQ(decision.done, points >= 7) << points;
    if (points >= 5) {
      EXPECT_EQ(decision.chosen, 3U) << points;
    }
  }
}

TEST(WeightChoice, HeldOutTakesTheLeastAndStopsWhenItRises) {
  std::vector<PathPoint> path;
  const std::vector<double> chi2{40.0, 5.0, 1.3, 1.1, 1.4};
  std::vector<bool> done;
  for (const double x : chi2) {
    PathPoint p;
    p.held_out_chi2 = x;
    path.push_back(p);
    done.push_back(choose_weight(WeightRule::held_out, path, 0.01).done);
  }
  EXPECT_EQ(choose_weight(WeightRule::held_out, path, 0.01).chosen, 3U);
  EXPECT_EQ(done, (std::vector<bool>{false, false, false, false, true}));
}

TEST(WeightChoice, HeldOutStopsWhereNothingIsGained) {
  std::vector<PathPoint> path(3);
  path[0].held_out_chi2 = 5.0;
  path[1].held_out_chi2 = 1.1;
  path[2].held_out_chi2 = 1.099;
  const WeightDecision decision = choose_weight(WeightRule::held_out, path, 0.01);
  EXPECT_TRUE(decision.done);
  EXPECT_EQ(decision.chosen, 2U);
}

}  // namespace
}  // namespace kappamu::inverse
