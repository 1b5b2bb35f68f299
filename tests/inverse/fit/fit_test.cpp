// The fit as a whole on small made-up blocks: recovers appearance to the noise, honours masks,
// quantities and sources, resumes to the same bits. The score against independent reference data is
// in transport_reference_test.cpp.
#include "inverse/fit/fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "core/error.h"
#include "device/device_info.h"
#include "inverse/block_model/homogeneous.h"
#include "inverse/problem/predict.h"
#include "tests/inverse/fit/fit_cases.h"
#include "tests/sentence.h"

namespace kappamu::inverse {
namespace {

using cases::Block;
using ::testing::HasSubstr;

CoefficientPair homogeneous(const GridShape& shape, double kappa, double mu) {
  return {std::vector<double>(shape.cells(), std::log(kappa)),
          std::vector<double>(shape.cells(), std::log(mu))};
}

/// Thin, hardly absorbing, with an inclusion that outshines any absorption: a homogeneous block
/// follows such data best with none at all.
CoefficientPair thin_structured(const GridShape& shape) {
  CoefficientPair fields = homogeneous(shape, 0.2, 3e-4);
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const double r = std::hypot((x + 0.5) / shape.nx - 0.35, (y + 0.5) / shape.ny - 0.6);
        const double bump = std::exp(-20.0 * r * r);
        fields.log_kappa[shape.index(x, y, z)] += 1.2 * bump;
        fields.log_mu[shape.index(x, y, z)] += 3.0 * (1.0 - bump) * (x + 0.5) / shape.nx;
      }
    }
  }
  return fields;
}

Block thin_block() {
  Block block;
  block.grid = {12, 10, 6, 0.6};
  block.noise = 0.002;
  return block;
}

TEST(HomogeneousStartOf, AThinBlockKeepsAPlausibleAbsorption) {
  const Block block = thin_block();
  const CoefficientPair truth = thin_structured(block.grid.refined(2));
  const HomogeneousFit fit = find_homogeneous(
      make_problem(cases::measure(block, truth), 0, forward::Convention::physical, {0.001, 5e-5}));
  EXPECT_TRUE(fit.converged);
  // Far below, log μ is a direction in which nothing changes, and no descent comes back from there.
  const double absorbed_share = 3.0 * fit.kappa * fit.mu;
  EXPECT_GT(absorbed_share, 1e-5);
  EXPECT_LT(absorbed_share, 0.1);
}

TEST(Fit, ThinBlockWithSharpDataConvergesOnOneGrid) {
  const Block block = thin_block();
  const CoefficientPair truth = thin_structured(block.grid.refined(2));
  const ChannelFit fit = cases::fit(cases::measure(block, truth), {});
  EXPECT_EQ(fit.report.history.front().level, 0) << "no coarser grid fits such a block";
  EXPECT_EQ(fit.report.status, FitStatus::converged) << fit.report.reason;
  // What the fit corrects for, and whoever solves on its volume must know.
  EXPECT_THAT(fit.report.warnings, ::testing::Each(::testing::HasSubstr("split the voxels")));
  constexpr double bound = 1e-3;  // the aim for any sample (docs/theory.md)
  EXPECT_LT(cases::validation_error(block, truth, fit.medium), bound);
}

TEST(Fit, ReachesTheNoiseAndPredictsOtherLight) {
  const Block block;
  const CoefficientPair truth = cases::smooth_medium(block.grid.refined(2));
  const ChannelFit fit = cases::fit(cases::measure(block, truth), {});
  EXPECT_EQ(fit.report.status, FitStatus::converged) << fit.report.reason;
  EXPECT_LE(fit.report.chi2_per_value, 1.0);
  EXPECT_GT(fit.report.chi2_per_value, 0.8) << "fits the noise";
  // The least any 1 % data have given on a block of this kind, with a margin of three.
  constexpr double bound = 4e-4;
  const double error = cases::validation_error(block, truth, fit.medium);
  EXPECT_LT(error, bound);
  const Medium start{Volume<double>(block.grid, fit.report.homogeneous_kappa),
                     Volume<double>(block.grid, fit.report.homogeneous_mu)};
  EXPECT_LT(error, 0.02 * cases::validation_error(block, truth, start));
}

TEST(Fit, EndsInTheSameVolumeWithItsVectorsOnADevice) {
  if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  const Block block;
  const CoefficientPair truth = cases::smooth_medium(block.grid.refined(2));
  const SurfaceMeasurements m = cases::measure(block, truth);
  FitOptions options;
  options.solver.backend.vectors = VectorPlace::host;
  const ChannelFit host = cases::fit(m, options);
  options.solver.backend.vectors = VectorPlace::device;
  const ChannelFit device = cases::fit(m, options);
  EXPECT_EQ(device.report.status, FitStatus::converged) << device.report.reason;
  EXPECT_EQ(device.report.weight, host.report.weight);
  // Rounding parts the steps of two fits, which then end within their tolerance of one minimum.
  EXPECT_NEAR(device.report.chi2_per_value, host.report.chi2_per_value, 1e-2);
  EXPECT_NEAR(device.report.solves.total(), host.report.solves.total(),
              0.2 * host.report.solves.total());
  const double error = cases::validation_error(block, truth, host.medium);
  EXPECT_NEAR(cases::validation_error(block, truth, device.medium), error, 0.2 * error);
}

TEST(Fit, GridCorrectionLowersTheErrorOnOtherGrids) {
  const Block block;
  const CoefficientPair truth = cases::smooth_medium(block.grid.refined(2));
  const SurfaceMeasurements m = cases::measure(block, truth);
  FitOptions without;
  without.path.correct_grid = false;
  const double corrected = cases::validation_error(block, truth, cases::fit(m, {}).medium);
  const double plain = cases::validation_error(block, truth, cases::fit(m, without).medium);
  EXPECT_LT(corrected, 0.7 * plain);
}

TEST(Fit, ExplainsTheDataOnTheFinerGridNotByAnOldCorrection) {
  Block block;
  block.noise = 0.001;
  const CoefficientPair truth = cases::smooth_medium(block.grid.refined(2));
  const SurfaceMeasurements m = cases::measure(block, truth);
  const ChannelFit fit = cases::fit(m, {});
  PredictOptions exact;
  exact.backend.solve.tolerance = 1e-6;
  const std::vector<float> finer = predict(fit.medium, m, exact);
  // Solves for r leave 1e-4 of the light, of dark pixels more; a correction from where the last
  // weight began is off by 1e-3 and more.
  constexpr double solver = 5e-4;
  for (std::size_t i = 0; i < finer.size(); ++i) {
    ASSERT_NEAR(fit.prediction[i] / finer[i], 1.0, solver) << i;
  }
}

/// Sharp data whose χ² the last correction, made when all seemed done, takes back above 1.
TEST(Fit, ALastCorrectionIsFittedToo) {
  Block block;
  block.noise = 0.005;
  test_cases::TruthSpec boxes;
  boxes.seed = 5;
  const CoefficientPair truth = test_cases::make_truth(block.grid.refined(2), boxes);
  const ChannelFit fit = cases::fit(test_cases::measure(block, truth, 4, 104), {});
  EXPECT_EQ(fit.report.status, FitStatus::converged) << fit.report.reason;
  EXPECT_LE(fit.report.chi2_per_value, 1.0);
}

TEST(Fit, WarnsWhereDiffusionDoesNotDescribeTheFittedVolume) {
  Block block;
  block.grid = {12, 12, 4, 0.5};
  const CoefficientPair truth = homogeneous(block.grid.refined(2), 0.4, 0.15);
  const ChannelFit fit = cases::fit(cases::measure(block, truth, 2), {});
  // 3 κ μ = 0.18, and 2 mm are 1.7 mean free paths.
  EXPECT_THAT(fit.report.warnings, ::testing::Contains(HasSubstr("3 kappa mu > 0.1")));
  EXPECT_THAT(fit.report.warnings, ::testing::Contains(HasSubstr("mean free paths thick")));
}

TEST(Fit, FrontLitSampleIsFittedFromUnlitPixels) {
  Block block;
  block.seen = Face::z_minus;
  const CoefficientPair truth = cases::smooth_medium(block.grid.refined(2));
  SurfaceMeasurements m = cases::measure(block, truth);
  // Masked data must not matter at all.
  for (std::size_t i = 0; i < m.value.size(); ++i) {
    if (m.mask[i] == 0) m.value[i] = std::numeric_limits<float>::quiet_NaN();
  }
  const ChannelFit fit = cases::fit(m, {});
  EXPECT_NE(fit.report.status, FitStatus::ran_out) << fit.report.reason;
  constexpr double bound = 2e-3;  // next to a patch's edge the lit face converges at order 1 only
  EXPECT_LT(cases::validation_error(block, truth, fit.medium), bound);
}

TEST(Fit, DiffuseLightEntersThroughTheBoundary) {
  Block block;
  block.light = Light::diffuse;
  const CoefficientPair truth = cases::smooth_medium(block.grid.refined(2));
  const ChannelFit fit = cases::fit(cases::measure(block, truth), {});
  constexpr double bound = 4e-4;
  EXPECT_LT(cases::validation_error(block, truth, fit.medium), bound);
}

TEST(Fit, RadianceAlongTheNormalGivesTheVolumesThatExitanceGives) {
  const Block exitance;
  Block radiance;
  radiance.quantity = Quantity::radiance_normal;
  const CoefficientPair truth = cases::smooth_medium(exitance.grid.refined(2));
  const ChannelFit a = cases::fit(cases::measure(exitance, truth), {});
  const SurfaceMeasurements measured = cases::measure(radiance, truth);
  const ChannelFit b = cases::fit(measured, {});
  // Same data up to rounding of float values; steps may differ by rounding too.
  constexpr double rounding = 0.02;
  for (std::size_t i = 0; i < a.medium.kappa.size(); ++i) {
    ASSERT_NEAR(a.medium.kappa[i] / b.medium.kappa[i], 1.0, rounding);
  }
  double ratio = 0.0;
  for (std::size_t i = 0; i < b.prediction.size(); ++i) {
    ratio += b.prediction[i] / measured.value[i] / static_cast<double>(b.prediction.size());
  }
  EXPECT_NEAR(ratio, 1.0, 0.05) << "the prediction is in the measured quantity";
}

/// Batched solves after the homogeneous start, that of the metric included.
int solves_to_reach(const FitReport& report, double objective) {
  const int start = report.history.front().solves.forward;
  for (const StepRecord& r : report.history) {
    if (r.objective <= objective) return r.solves.forward + r.solves.adjoint - start;
  }
  return std::numeric_limits<int>::max();
}

TEST(Fit, EachOptimiserNeedsFewerSolvesThanThePapers) {
  Block block;
  block.grid = {12, 12, 4, 0.5};
  const CoefficientPair truth = cases::smooth_medium(block.grid.refined(2));
  const SurfaceMeasurements m = cases::measure(block, truth, 3);
  FitOptions options;
  options.path.weight = 300.0;
  options.path.max_levels = 1;
  options.path.stage_tolerance = 1e-6;  // steps alone end it
  options.path.stage_steps = 60;
  const FitReport ours = cases::fit(m, options).report;
  FitOptions voxels = options;
  voxels.solver.coordinates = Coordinates::voxels;
  const FitReport plain = cases::fit(m, voxels).report;
  FitOptions paper = voxels;
  paper.solver.optimiser.method = Method::wang2008;
  paper.path.stage_steps = 30;
  const FitReport papers = cases::fit(m, paper).report;
  // All minimise the same function; compare where the paper's got.
  const double reached = papers.history.back().objective;
  EXPECT_LT(reached, 0.5 * papers.history.front().objective) << "the baseline does not descend";
  const int baseline = solves_to_reach(papers, reached);
  EXPECT_LT(solves_to_reach(plain, reached), baseline / 2) << "of " << baseline;
  RecordProperty("solves_wang2008", baseline);
  RecordProperty("solves_lbfgs_voxels", solves_to_reach(plain, reached));
  RecordProperty("solves_lbfgs_informed", solves_to_reach(ours, reached));
  std::printf("objective %.5g after %d solves (wang2008), %d (L-BFGS), %d (informed L-BFGS)\n",
              reached, baseline, solves_to_reach(plain, reached), solves_to_reach(ours, reached));
  EXPECT_LT(solves_to_reach(ours, reached), 0.4 * baseline);
}

TEST(Fit, BadInputIsToldInOneSentence) {
  Block block;
  block.grid = {8, 8, 4, 0.5};
  SurfaceMeasurements m = cases::measure(block, cases::smooth_medium(block.grid.refined(2)), 2);
  const auto sentence = [&](const FitOptions& options) {
    return sentence_of([&] { cases::fit(m, options); });
  };
  FitOptions options;
  options.path.weight_factor = 1.0;
  EXPECT_THAT(sentence(options), HasSubstr("weight_factor must lie in (0, 1)"));
  options = {};
  options.path.weight = -1.0;
  EXPECT_THAT(sentence(options), HasSubstr("fit options: weight must not be negative"));
  options = {};
  options.solver.backend.device = "no such device";
  EXPECT_THAT(sentence(options), HasSubstr("no such device"));
  for (float& v : m.value) v = 0.0F;
  EXPECT_THAT(sentence({}), HasSubstr("no datum stands three standard deviations above zero"));
}

}  // namespace
}  // namespace kappamu::inverse
