// What limits E on a block with sharp inclusions: the regulariser, not the noise. The same weight
// is fitted to the same light without noise, from where the noisy fit ended: the E that stays is
// the smoothing's bias (docs/theory.md, section 4).
#include <gtest/gtest.h>

#include <cstdio>

#include "inverse/fit/fit.h"
#include "tests/cases/inverse_case.h"

namespace kappamu::inverse {
namespace {

struct Errors {
  double noisy = 0.0;
  double without_noise = 0.0;
};

/// E under 8 × 8 patches of 16 × 16 × 6 voxels at 1 % noise.
Errors errors_of(bool inclusions, const RegulariserOptions& regulariser) {
  test_cases::Block block;
  test_cases::TruthSpec spec;
  spec.inclusions = inclusions;
  const CoefficientPair truth = test_cases::make_truth(block.grid.refined(2), spec);
  const SurfaceMeasurements clean = test_cases::expose_patches(block, truth, 4);
  const SurfaceMeasurements validation = test_cases::expose_patches(block, truth, 8);
  SurfaceMeasurements m = clean;
  test_cases::add_noise(m, block.noise, 101);
  FitOptions options;
  options.path.model = Model::volume;
  options.regulariser = regulariser;
  Progress silent;
  const ChannelFit fit = fit_channel(m, 0, options, {}, silent);
  FitContext context;
  context.continued = {fit.medium, fit.report.homogeneous_kappa, fit.report.homogeneous_mu,
                       fit.report.homogeneous_log_residual, fit.report.weight};
  options.path.weight = fit.report.weight;
  m.value = clean.value;
  const ChannelFit exact = fit_channel(m, 0, options, {}, silent, {}, context);
  return {test_cases::appearance_error(fit.medium, validation),
          test_cases::appearance_error(exact.medium, validation)};
}

TEST(SmoothingBias, IsMostOfTheErrorWhereInclusionsAreSharp) {
  const RegulariserOptions h1{RegulariserKind::h1};
  const RegulariserOptions huber{RegulariserKind::huber_tv};
  const Errors smooth = errors_of(false, h1);
  const Errors boxes = errors_of(true, h1);
  const Errors edges = errors_of(true, huber);
  std::printf(
      "E at 1 %% noise and at the same weight without: smooth block %.2g, %.2g; with boxes "
      "%.2g, %.2g; these by huber-tv %.2g, %.2g\n",
      smooth.noisy, smooth.without_noise, boxes.noisy, boxes.without_noise, edges.noisy,
      edges.without_noise);
  EXPECT_GT(boxes.without_noise, 0.5 * boxes.noisy);
  EXPECT_GT(boxes.without_noise, smooth.without_noise);
  EXPECT_LT(edges.without_noise, boxes.without_noise);
}

}  // namespace
}  // namespace kappamu::inverse
