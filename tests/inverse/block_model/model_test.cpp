// The simplest block that the data do not reject: homogeneous data give a homogeneous block, layers
// give layers, structure a volume; and each is validated under light that was not fitted. Data are
// of a grid three times as fine as the fitted one, the correction is of one twice as fine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "inverse/block_model/model_choice.h"
#include "inverse/block_model/model_evidence.h"
#include "inverse/block_model/model_layers.h"
#include "inverse/validation/simpler_model.h"
#include "tests/cases/limit_inverse_case.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

using ::testing::HasSubstr;

constexpr int fine = 3;

struct Fitted {
  ChannelFit fit;
  double error = 0.0;  ///< E under 8 × 8 patches
};

Fitted fit_block(const test_cases::Block& block, const test_cases::Figure3& truth,
                 const FitOptions& options, const test_cases::Mistake& mistake = {}) {
  SurfaceMeasurements m = test_cases::expose_figure(block, truth, 4, fine);
  test_cases::spoil(m, block.noise, mistake);
  Fitted result{cases::fit(m, options), 0.0};
  result.error = test_cases::appearance_error(result.fit.medium,
                                              test_cases::expose_figure(block, truth, 8, fine));
  return result;
}

/// (largest − smallest)/smallest.
double spread(const Volume<double>& volume) {
  const auto [low, high] = std::minmax_element(volume.values().begin(), volume.values().end());
  return *high / *low - 1.0;
}

/// Voxels of half a mean free path, so that the data's own grid matters little.
test_cases::Block block() {
  test_cases::Block b;
  b.grid = {16, 16, 10, 0.3};
  return b;
}

TEST(Model, HomogeneousBlockComesOutHomogeneous) {
  const Fitted fitted = fit_block(block(), test_cases::even_block(0.2, 0.02), {});
  const FitReport& report = fitted.fit.report;
  EXPECT_EQ(report.model.model, Model::homogeneous) << report.model.reason;
  EXPECT_EQ(report.status, FitStatus::converged);
  EXPECT_THAT(report.model.reason, HasSubstr("A homogeneous block (chi2 per value"));
  constexpr double must_spread = 0.02;
  constexpr double must_error = 2e-5;
  EXPECT_LT(spread(fitted.fit.medium.kappa), must_spread);
  EXPECT_LT(spread(fitted.fit.medium.mu), must_spread);
  EXPECT_LT(fitted.error, must_error);
  std::printf("homogeneous: E %.2g\n", fitted.error);
}

TEST(Model, LayeredBlockComesOutLayered) {
  const Fitted fitted = fit_block(block(), test_cases::layered_block(0.25, 0.03), {});
  const FitReport& report = fitted.fit.report;
  EXPECT_EQ(report.model.model, Model::layered) << report.model.reason;
  EXPECT_LT(report.model.layers, block().grid.nz) << "as few as the data need";
  constexpr double must_error = 5e-5;
  EXPECT_LT(fitted.error, must_error);
  std::printf("%d layers: E %.2g\n", report.model.layers, fitted.error);
  // Across the light nothing varies.
  const GridShape& s = block().grid;
  for (int z = 0; z < s.nz; ++z) {
    EXPECT_EQ(fitted.fit.medium.kappa(0, 0, z), fitted.fit.medium.kappa(s.nx - 1, s.ny / 2, z));
  }
}

TEST(Model, StructureIsMistakenForNeither) {
  // Down to a contrast of 1.2, where a homogeneous block leaves only 2 % of the light unexplained.
  for (const double strength : {1.0, 0.15}) {
    FitOptions options;
    options.path.stage_steps = 2;  // the choice is what is asked
    SurfaceMeasurements m = test_cases::expose_figure(
        block(), test_cases::structured_block(0.2, 0.02, strength, 0), 4, fine);
    test_cases::spoil(m, 0.01, {});
    const FitReport report = cases::fit(m, options).report;
    EXPECT_EQ(report.model.model, Model::volume) << strength << ": " << report.model.reason;
    EXPECT_THAT(report.model.reason, HasSubstr("Neither a homogeneous block"));
  }
}

TEST(Model, WhatIsAskedForIsFittedAndSaidNotToSuffice) {
  FitOptions options;
  options.path.model = Model::homogeneous;
  const Fitted fitted =
      fit_block(block(), test_cases::structured_block(0.2, 0.02, 1.0, 0), options);
  const FitReport& report = fitted.fit.report;
  EXPECT_EQ(report.model.model, Model::homogeneous);
  EXPECT_EQ(report.status, FitStatus::above_noise);
  EXPECT_LT(spread(fitted.fit.medium.kappa), 1e-9);
  EXPECT_THAT(report.warnings,
              ::testing::Contains(HasSubstr("was asked for, but does not explain the data")));
}

TEST(Model, ValidationOverrulesUnderstatedVariances) {
  // Variances a quarter of the true ones, by more than systematic error is taken to be: nothing
  // explains the data to what they state.
  const test_cases::Figure3 truth = test_cases::even_block(0.2, 0.02);
  const test_cases::Block b = block();
  constexpr double noise = 0.03;
  SurfaceMeasurements m = test_cases::expose_figure(b, truth, 4, fine);
  test_cases::spoil(m, noise, {.variance = 0.25});
  SurfaceMeasurements validation = test_cases::expose_figure(b, truth, 2, fine);
  test_cases::spoil(validation, noise, {.variance = 0.25}, 8);
  FitOptions options;
  options.path.stage_steps = 20;
  ChannelFit fit = cases::fit(m, options);
  EXPECT_EQ(fit.report.model.model, Model::volume) << fit.report.model.reason;
  prefer_simpler(fit, m, validation, 0, options);
  EXPECT_EQ(fit.report.model.model, Model::homogeneous) << fit.report.model.reason;
  EXPECT_THAT(fit.report.model.reason, HasSubstr("so the simpler block is kept"));
  EXPECT_EQ(fit.report.status, FitStatus::above_noise);
  EXPECT_NEAR(fit.report.chi2_per_value, 4.0, 0.4) << "not the block's own, of the true noise";
  EXPECT_LT(spread(fit.medium.kappa), 1e-9);
}

TEST(Model, ValidationKeepsTheVolumeWhereThereIsStructure) {
  const test_cases::Figure3 truth = test_cases::structured_block(0.2, 0.02, 0.3, 0);
  const test_cases::Block b = block();
  SurfaceMeasurements m = test_cases::expose_figure(b, truth, 4, fine);
  test_cases::spoil(m, b.noise, {});
  SurfaceMeasurements validation = test_cases::expose_figure(b, truth, 2, fine);
  test_cases::spoil(validation, b.noise, {}, 8);
  FitOptions options;
  options.path.stage_steps = 20;
  ChannelFit fit = cases::fit(m, options);
  fit.simpler.push_back(
      {{0}, {std::log(fit.report.homogeneous_kappa)}, {std::log(fit.report.homogeneous_mu)}});
  prefer_simpler(fit, m, validation, 0, options);
  EXPECT_EQ(fit.report.model.model, Model::volume) << fit.report.model.reason;
}

TEST(Model, NamesAreUnderstoodAndOthersNot) {
  for (const char* name : {"auto", "homogeneous", "layered", "volume"}) {
    EXPECT_EQ(to_string(value_of(model_names, name).value()), name);
  }
  EXPECT_FALSE(value_of(model_names, "cubes"));
}

TEST(Layers, CoverTheDepthWhateverTheirNumber) {
  for (const int depth : {1, 7, 10, 16}) {
    for (int layers = 1; layers <= depth; ++layers) {
      const LayeredMedium m = with_layers({{0}, {1.0}, {2.0}}, layers, depth);
      ASSERT_EQ(m.layers(), layers);
      EXPECT_EQ(m.first.front(), 0);
      for (int l = 1; l < layers; ++l) EXPECT_GT(m.first[l], m.first[l - 1]);
      EXPECT_LT(m.first.back(), depth);
    }
  }
}

TEST(Layers, AlikeOnesMergeWithinTheAllowance) {
  const LayeredMedium m{{0, 1, 2, 3}, {0.0, 0.01, 1.0, 1.01}, {0.0, 0.01, 0.0, 0.01}};
  const Eigen::MatrixXd normal = 1e4 * Eigen::MatrixXd::Identity(8, 8);
  // Each join of neighbours 0.01 apart in both costs 2 · 1e4 · 0.01²/2 = 1; that in the middle
  // 5000.
  EXPECT_EQ(merge_layers(m, normal, 0.9).layers(), 4);
  EXPECT_EQ(merge_layers(m, normal, 1.1).layers(), 3);
  const LayeredMedium two = merge_layers(m, normal, 2.1);
  EXPECT_EQ(two.first, (std::vector<int>{0, 2}));
  EXPECT_NEAR(two.log_kappa[0], 0.005, 1e-12);
  EXPECT_NEAR(two.log_kappa[1], 1.005, 1e-12);
  EXPECT_EQ(merge_layers(m, normal, 1e6).layers(), 1);
}

TEST(Evidence, TellsNoiseFromMisfitWhateverTheStatedVariance) {
  const test_cases::Block b = block();
  SurfaceMeasurements m = test_cases::expose_figure(b, test_cases::even_block(0.2, 0.02), 4, 2);
  const std::vector<float> clean = m.value;
  test_cases::spoil(m, 0.01, {.variance = 4.0});
  const Problem problem = make_problem(m, 0, forward::Convention::physical, {});
  std::vector<double> prediction(clean.begin(), clean.end());
  const Evidence right = weigh(problem, prediction, {});
  constexpr double five_errors = 5.0;
  EXPECT_NEAR(right.chi2_per_value, 0.25, 0.02);
  EXPECT_LT(std::abs(right.coherence), five_errors * right.coherence_error);
  // Half a per cent of misfit: its share of χ² is what neighbours have in common.
  double misfit = 0.0;
  for (std::size_t i = 0; i < prediction.size(); ++i) {
    const double change = 0.005 * prediction[i];
    prediction[i] += change;
    misfit += problem.weight[i] * change * change;
  }
  const Evidence wrong = weigh(problem, prediction, {});
  const double share = misfit / (wrong.chi2_per_value * static_cast<double>(wrong.data));
  EXPECT_GT(share, 0.05) << "too little to ask for";
  EXPECT_NEAR(wrong.coherence, share, five_errors * wrong.coherence_error);
  EXPECT_TRUE(not_rejected(right, 0.05));
}

}  // namespace
}  // namespace kappamu::inverse
