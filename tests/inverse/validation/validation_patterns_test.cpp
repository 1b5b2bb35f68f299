// Patterns kept out of the fit: which, how the others stay as they are, and what the score means.
#include "inverse/validation/validation_patterns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/error.h"
#include "inverse/validation/notes.h"
#include "tests/cases/media.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

SurfaceMeasurements numbered(int side) {
  SurfaceMeasurements m;
  m.grid = {8, 8, 4, 0.5};
  m.channels = {"R", "G"};
  m.patterns = side * side;
  const std::vector<double> light = test_cases::patch_light(m.grid, m.lit_face, m.patterns);
  m.irradiance.assign(light.begin(), light.end());
  const std::size_t cells = m.seen_shape().cells();
  for (std::size_t c = 0; c < 2; ++c) {
    for (int p = 0; p < m.patterns; ++p) {
      m.value.insert(m.value.end(), cells, static_cast<float>(100 * (c + 1) + p));
    }
  }
  m.variance.assign(m.value.size(), 1.0F);
  return m;
}

TEST(ValidationPatterns, OneOfSixteenAndNoneOfThree) {
  EXPECT_EQ(usual_validation_count(1), 0);
  EXPECT_EQ(usual_validation_count(3), 0);
  EXPECT_EQ(usual_validation_count(4), 1);
  EXPECT_EQ(usual_validation_count(16), 1);
  EXPECT_EQ(usual_validation_count(64), 4);
}

TEST(ValidationPatterns, ChosenPatternsHaveNeighboursAllAround) {
  const SurfaceMeasurements m = numbered(4);
  // The middle four of 4 × 4 patches are 5, 6, 9 and 10.
  EXPECT_THAT(choose_validation_patterns(m, 0), ElementsAre());
  EXPECT_THAT(choose_validation_patterns(m, 1), ElementsAre(5));
  EXPECT_THAT(choose_validation_patterns(m, 2), ElementsAre(5, 10));
  EXPECT_THAT(choose_validation_patterns(m, 4), ElementsAre(5, 6, 9, 10));
  EXPECT_EQ(choose_validation_patterns(m, 15).size(), 15U);
  EXPECT_THROW(choose_validation_patterns(m, 16), InputError);
}

TEST(ValidationPatterns, PartsTogetherAreTheWhole) {
  SurfaceMeasurements m = numbered(2);
  m.mask.assign(m.value.size(), 1);
  m.mask[m.seen_shape().cells() * 2] = 0;  // of channel R, pattern 2
  const std::vector<int> out{2};
  const SurfaceMeasurements validation = select_patterns(m, out);
  const SurfaceMeasurements fitted = without_patterns(m, out);
  validate(validation, "validation");
  validate(fitted, "fitted");
  const std::size_t cells = m.seen_shape().cells();
  EXPECT_EQ(validation.patterns, 1);
  EXPECT_EQ(validation.value.front(), 102.0F);
  EXPECT_EQ(validation.value[cells], 202.0F);
  EXPECT_EQ(validation.mask.front(), 0);
  EXPECT_EQ(fitted.patterns, 3);
  EXPECT_EQ(fitted.value[2 * cells], 103.0F);
  EXPECT_EQ(fitted.value[3 * cells], 200.0F);
  EXPECT_EQ(fitted.irradiance.size() + validation.irradiance.size(), m.irradiance.size());
  EXPECT_THROW(select_patterns(m, std::vector<int>{4}), InputError);
}

TEST(ValidationPatterns, ScoreOfTheTruthIsTheNoise) {
  cases::Block block;
  block.grid = {12, 12, 4, 0.5};
  const CoefficientPair fine = cases::rough_medium(block.grid, 0.2, 3);
  // The truth on the fitted grid, so that nothing but noise is left.
  const GridShape split = block.grid.refined(2);
  const CoefficientPair truth{split_voxels(fine.log_kappa, block.grid, split, 2),
                              split_voxels(fine.log_mu, block.grid, split, 2)};
  for (const Quantity quantity : {Quantity::exitance, Quantity::radiance_normal}) {
    block.quantity = quantity;
    const SurfaceMeasurements m = cases::measure(block, truth);
    const Medium medium{Volume<double>(block.grid, exponential(fine.log_kappa)),
                        Volume<double>(block.grid, exponential(fine.log_mu))};
    const ValidationScore score = validation_score(medium, m, 0, {}, {});
    EXPECT_EQ(score.error.count, m.value.size());
    // Sums of 2304 squares of normal numbers; E's are dominated by the bright few hundred.
    constexpr double four_sigma = 4.0;
    EXPECT_NEAR(score.chi2_per_value, 1.0, four_sigma * std::sqrt(2.0 / 2304.0));
    EXPECT_NEAR(score.error.E() / score.error.noise_E(), 1.0, four_sigma * std::sqrt(2.0 / 200.0));
  }
}

/// As the demo's: fitted light within its deviations, held-out light 5.6 of them off.
TEST(ValidationPatterns, DeviationsOfValidationPatternsAreNoted) {
  ChannelFit fit;
  fit.report.model.model = Model::homogeneous;
  fit.report.chi2_per_value = 0.9;
  ValidationScore score;
  score.chi2_per_value = 31.0;
  EXPECT_THAT(
      notes_on(fit, numbered(2), score),
      ElementsAre(HasSubstr(
          "Validation patterns deviate from the prediction by 5.6 of their stated standard")));
  score.chi2_per_value = 3.9;
  EXPECT_THAT(notes_on(fit, numbered(2), score), IsEmpty());
  EXPECT_THAT(notes_on(fit, numbered(2)), IsEmpty());
}

}  // namespace
}  // namespace kappamu::inverse
