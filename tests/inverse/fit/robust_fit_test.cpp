// Whole fits with other losses and regularisers, each against the fit without them. The data
// term alone is tested in data_term_test.cpp, the regularisers in roughness_test.cpp; medians over
// more truths and noises are `kappamu-studies inverse --section losses`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "inverse/optimise/fit_function.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

using cases::Block;
using cases::Noise;

/// 12 × 12 × 4 voxels under 3 × 3 patches, 1 % noise.
struct SmallCase {
  SmallCase() {
    block.grid = {12, 12, 4, 0.5};
    truth = cases::smooth_medium(block.grid.refined(2));
    measured = cases::measure(block, truth, 3);
  }
  double error(const SurfaceMeasurements& m, const FitOptions& options) const {
    return cases::validation_error(block, truth, cases::fit(m, options).medium);
  }
  Block block;
  CoefficientPair truth;
  SurfaceMeasurements measured;
};

TEST(RobustFit, OnePercentOfWildPixelsSpoilsTheGaussianFitAlone) {
  const SmallCase c;
  SurfaceMeasurements wild = c.measured;
  Noise noise(5);
  const float largest = *std::max_element(wild.value.begin(), wild.value.end());
  for (float& value : wild.value) {
    if (noise.uniform() < 0.01) value = static_cast<float>(largest * noise.uniform());
  }
  FitOptions huber;
  huber.data.term.loss = Loss::huber;
  FitOptions student;
  student.data.term.loss = Loss::student;
  const double clean = c.error(c.measured, {});
  const double spoilt = c.error(wild, {});
  const double by_huber = c.error(wild, huber);
  const double by_student = c.error(wild, student);
  std::printf("E %.2g clean; with 1 %% wild: gaussian %.2g, huber %.2g, student %.2g\n", clean,
              spoilt, by_huber, by_student);
  EXPECT_GT(spoilt, 3.0 * clean);
  EXPECT_LT(by_huber, 0.5 * spoilt);
  EXPECT_LT(by_student, 0.5 * spoilt);
}

TEST(RobustFit, DerivativeIsExactInTheCoordinatesTheFitMovesIn) {
  const SmallCase c;
  Backend backend;
  backend.device = "reference";
  backend.precision = forward::Precision::double_precision;
  backend.solve = {1e-13, 2000};
  DataTermOptions data;
  data.loss = Loss::huber;
  Objective objective(make_problem(c.measured, 0, forward::Convention::physical, {0.001, 5e-5}),
                      backend, data);
  const GridShape& shape = objective.problem().setup.shape;
  const double thickness = 2.0;
  const CoefficientPair at = cases::rough_medium(shape, 0.1, 5);
  const Basis basis({shape, 2, thickness}, {Coordinates::smooth, thickness, 10.0}, {});
  const Anchor anchor{std::log(0.15), std::log(0.05), 20.0};
  FitFunction function(objective, basis, anchor, 10.0, {RegulariserKind::huber_tv, 0.5, 1.0}, at,
                       AbsorptionScale(0.02));
  const Vector z = function.coordinates(at);
  const Vector direction = basis.from_fields(cases::random_direction(shape, 6));
  const double value = function.value(z);
  const Vector gradient = function.gradient();
  double slope = 0.0;
  for (std::size_t i = 0; i < z.size(); ++i) slope += gradient[i] * direction[i];
  std::vector<double> remainders;
  for (const double step : {1e-3, 1e-4}) {
    Vector moved = z;
    for (std::size_t i = 0; i < z.size(); ++i) moved[i] += step * direction[i];
    remainders.push_back(std::abs(function.value(moved) - value - step * slope));
  }
  constexpr double blur = 0.2;  // Huber's second derivatives jump
  EXPECT_NEAR(std::log10(remainders[0] / remainders[1]), 2.0, blur);
}

TEST(RobustFit, GoesOnFromAFinishedFit) {
  const SmallCase c;
  FitOptions smooth;
  smooth.path.target_chi2 = 4.0;
  const ChannelFit first = cases::fit(c.measured, smooth);
  FitContext context;
  context.continued =
      Continuation{first.medium, first.report.homogeneous_kappa, first.report.homogeneous_mu,
                   first.report.homogeneous_log_residual, first.report.weight};
  Progress silent;
  const ChannelFit second = fit_channel(c.measured, 0, {}, {}, silent, {}, context);
  EXPECT_EQ(second.report.history.front().level, 0) << "no coarser grid once more";
  EXPECT_LT(second.report.chi2_per_value, 0.5 * first.report.chi2_per_value);
  // It ends about where a fit at once ends.
  const double at_once = c.error(c.measured, {});
  EXPECT_LT(cases::validation_error(c.block, c.truth, second.medium), 2.0 * at_once);
}

}  // namespace
}  // namespace kappamu::inverse
