// Calibration error against the number of views: that it falls, and is what the calibrations state.
#include "studies/calibration/views.h"

#include <gtest/gtest.h>

namespace kappamu::studies {
namespace {

TEST(Views, MoreOfThemCalibrateBetterAndSayHowWell) {
  Progress silent;
  ViewsOptions options;
  options.views = {6, 24};
  options.runs = 5;
  const auto cases = measure_views(options, silent);
  ASSERT_EQ(cases.size(), 2U);
  EXPECT_EQ(cases[1].refused, 0);
  // Twice the error for a quarter of the views, and few views often lie badly.
  EXPECT_LT(cases[1].error_px, 0.8 * cases[0].error_px);
  for (const ViewsCase& c : cases) {
    // Five runs know a root mean square to a third.
    EXPECT_GT(c.error_px, 0.4 * c.predicted_px) << c.views;
    EXPECT_LT(c.error_px, 2.5 * c.predicted_px) << c.views;
  }
}

// Three views do not tell p1 and p2: what that leaves open must be in the stated deviation.
TEST(Views, FewOfThemStateWhatTheyAreWorth) {
  Progress silent;
  ViewsOptions options;
  options.views = {3, 6};
  const auto cases = measure_views(options, silent);
  for (const ViewsCase& c : cases) {
    std::printf("%d views: error %.3f px, stated %.3f px\n", c.views, c.error_px, c.predicted_px);
    EXPECT_NEAR(c.predicted_px / c.error_px, 1.0, 0.25) << c.views;
  }
}

}  // namespace
}  // namespace kappamu::studies
