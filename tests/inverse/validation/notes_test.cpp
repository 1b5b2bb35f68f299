// A pattern whose photographs are wrong as a whole is named; scattered outliers are not put on one.
#include "inverse/validation/notes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstddef>

namespace kappamu::inverse {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr int patterns = 12;
constexpr std::size_t cells = 80;

struct Case {
  ChannelFit fit;
  SurfaceMeasurements measured;
};

/// All values one to two deviations off a prediction of 1.
Case usual() {
  Case one;
  one.fit.report.chi2_per_value = 100.0;
  one.fit.prediction.assign(patterns * cells, 1.0F);
  one.measured.patterns = patterns;
  for (std::size_t i = 0; i < patterns * cells; ++i) {
    one.measured.value.push_back(1.0F + (i % 2 == 0 ? 0.01F : -0.02F));
  }
  one.measured.variance.assign(patterns * cells, 1e-4F);
  return one;
}

TEST(OutlierWarning, NamesThePatternThatIsWrongAsAWhole) {
  Case one = usual();
  for (std::size_t i = 5 * cells; i < 6 * cells; ++i) one.measured.value[i] = 0.0F;
  EXPECT_THAT(outlier_warning(one.fit, one.measured, 0).value_or(""),
              HasSubstr("most of them under pattern 5 (from 0)"));
  constexpr std::array<int, 3> kept_out{0, 6, 9};  // then the sixth that was fitted is number 7
  EXPECT_THAT(outlier_warning(one.fit, one.measured, 0, kept_out).value_or(""),
              HasSubstr("under pattern 7 (from 0)"));
}

TEST(OutlierWarning, ScatteredOutliersAreOfNoPattern) {
  Case one = usual();
  for (std::size_t i = 0; i < patterns * cells; i += 37) one.measured.value[i] = 0.0F;
  const std::string warning = outlier_warning(one.fit, one.measured, 0).value_or("");
  EXPECT_THAT(warning, HasSubstr("mask them"));
  EXPECT_THAT(warning, Not(HasSubstr("under pattern")));
}

}  // namespace
}  // namespace kappamu::inverse
