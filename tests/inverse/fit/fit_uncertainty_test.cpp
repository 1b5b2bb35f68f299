// Standard deviations of homogeneous and layered blocks: predicted against the spread of fits to
// fresh noise, each from its own start. Those of volumes: uncertainty_test.cpp and
// tests/studies/uncertainty_proof_test.cpp.
#include "inverse/fit/fit_uncertainty.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "inverse/block_model/homogeneous.h"
#include "inverse/block_model/model_layers.h"
#include "tests/cases/limit_inverse_case.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr ModelError model_error{0.001, 5e-5};

/// The layers of `truth`, in shares of the depth of `slices`.
test_cases::Figure3 figure_of(const LayeredMedium& truth, int slices) {
  return [=](double, double, double c) {
    const int slice = static_cast<int>(c * slices);
    const auto after = std::upper_bound(truth.first.begin(), truth.first.end(), slice);
    const auto l = static_cast<std::size_t>(after - truth.first.begin() - 1);
    return test_cases::Material{truth.log_kappa[l], truth.log_mu[l]};
  };
}

const LayeredMedium even{{0}, {std::log(0.2)}, {std::log(0.02)}};
/// Two slices each, contrast 2 in κ and in μ.
const LayeredMedium three{{0, 2, 4},
                          {std::log(0.3), std::log(0.15), std::log(0.3)},
                          {std::log(0.02), std::log(0.02), std::log(0.04)}};

Eigen::VectorXd joined(const LayeredMedium& medium) {
  const Eigen::Index layers = medium.layers();
  Eigen::VectorXd u(2 * layers);
  u.head(layers) = Eigen::Map<const Eigen::VectorXd>(medium.log_kappa.data(), layers);
  u.tail(layers) = Eigen::Map<const Eigen::VectorXd>(medium.log_mu.data(), layers);
  return u;
}

/// Standard deviations of every unknown, κ of the layers, then μ: predicted at the truth, and of
/// fits to `count` noises, each from the homogeneous start that the program takes.
struct Spread {
  Eigen::VectorXd predicted, sampled;
};
Spread spread_of_fits(const LayeredMedium& truth, int count) {
  test_cases::Block block;
  block.grid = {8, 8, 6, 0.5};
  const SurfaceMeasurements exact =
      test_cases::expose_figure(block, figure_of(truth, block.grid.nz), 3, 2);
  Spread spread;
  std::vector<Eigen::VectorXd> found;
  for (int k = 0; k < count; ++k) {
    SurfaceMeasurements m = exact;
    test_cases::spoil(m, block.noise, {}, static_cast<std::uint64_t>(k) + 1);
    const Problem problem = make_problem(m, 0, forward::Convention::physical, model_error);
    Objective objective(problem, {});
    // One correction for all, as for one block: its own changes are no noise.
    objective.refresh_correction(refine(problem), to_fields(truth, {block.grid}));
    if (k == 0) {
      spread.predicted = LayerFitter(objective, truth).covariance().diagonal().cwiseSqrt();
    }
    const HomogeneousFit start = find_homogeneous(problem);
    const LayeredMedium begin{{0}, {std::log(start.kappa)}, {std::log(start.mu)}};
    LayerFitter fitter(objective, with_layers(begin, truth.layers(), block.grid.nz));
    found.push_back(joined(fitter.descend().medium));
  }
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(spread.predicted.size());
  for (const Eigen::VectorXd& u : found) mean += u / count;
  Eigen::VectorXd square = Eigen::VectorXd::Zero(mean.size());
  for (const Eigen::VectorXd& u : found) square += (u - mean).cwiseAbs2() / (count - 1.0);
  spread.sampled = square.cwiseSqrt();
  return spread;
}

/// What the data hardly know is not normal in its logarithm, and the prior has a say.
constexpr double hardly_known = 0.2;

void expect_predicted(const char* name, const Spread& spread) {
  int known = 0;
  for (Eigen::Index k = 0; k < spread.predicted.size(); ++k) {
    const double ratio = spread.sampled[k] / spread.predicted[k];
    std::printf("%s, unknown %d: predicted %.3g, sampled over predicted %.2f\n", name,
                static_cast<int>(k), spread.predicted[k], ratio);
    if (spread.predicted[k] > hardly_known) continue;
    ++known;
    constexpr double quarter = 0.25;  // 60 fits know a deviation to 9 %
    EXPECT_NEAR(ratio, 1.0, quarter) << k;
  }
  EXPECT_GE(known, 2);
}

TEST(ModelUncertainty, FitsOfAHomogeneousBlockSpreadAsPredicted) {
  expect_predicted("homogeneous", spread_of_fits(even, 60));
}

TEST(ModelUncertainty, FitsOfLayersSpreadAsPredicted) {
  expect_predicted("three layers", spread_of_fits(three, 60));
}

constexpr GridShape grid{12, 12, 6, 0.5};

ChannelFit fit_model(const LayeredMedium& truth, SurfaceMeasurements& m) {
  test_cases::Block block;
  block.grid = grid;
  m = test_cases::expose_figure(block, figure_of(truth, grid.nz), 4, 2);
  test_cases::spoil(m, block.noise, {});
  return cases::fit(m, {});
}

TEST(ModelUncertainty, SaysTheNumbersOfAHomogeneousBlock) {
  SurfaceMeasurements m;
  const ChannelFit fit = fit_model(even, m);
  ASSERT_EQ(fit.report.model.model, Model::homogeneous);
  const Uncertainty found = estimate_model_uncertainty(fit, m, 0, {});
  EXPECT_EQ(found.log_kappa_std.shape(), grid);
  EXPECT_EQ(found.log_kappa_std[0], found.log_kappa_std[found.log_kappa_std.size() - 1]);
  // Within four of what it states of the truth.
  EXPECT_LT(std::abs(std::log(fit.medium.kappa[0] / 0.2)), 4.0 * found.log_kappa_std[0]);
  EXPECT_LT(std::abs(std::log(fit.medium.mu[0] / 0.02)), 4.0 * found.log_mu_std[0]);
  EXPECT_THAT(found.report.sentence,
              AllOf(HasSubstr("κ is 0.2"), HasSubstr(" mm within "), HasSubstr("correlation"),
                    HasSubstr("if the block is homogeneous and scale, pose and eta are right")));
  std::printf("%s\n", found.report.sentence.c_str());
}

TEST(ModelUncertainty, SaysTheNumbersOfEveryLayer) {
  SurfaceMeasurements m;
  const ChannelFit fit = fit_model(three, m);
  ASSERT_EQ(fit.report.model.model, Model::layered);
  const Uncertainty found = estimate_model_uncertainty(fit, m, 0, {});
  ASSERT_EQ(layers_of(fit.medium, 2).layers(), fit.report.model.layers);
  ASSERT_EQ(found.report.layers.size(), static_cast<std::size_t>(grid.nz));
  EXPECT_THAT(found.report.sentence, AllOf(HasSubstr("z from 0 to "), HasSubstr("to 3 mm: κ is "),
                                           HasSubstr("if the block is of these layers")));
  std::printf("%s\n", found.report.sentence.c_str());
}

}  // namespace
}  // namespace kappamu::inverse
