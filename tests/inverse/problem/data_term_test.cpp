// The data term alone, without a solver: its derivative, what the losses make of wild data.
// How a fit fares with them is in robust_fit_test.cpp.
#include "inverse/problem/data_term.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse {
namespace {

constexpr int patterns = 3;

/// 7 × 5 pixels, three patterns, a few masked.
Problem noisy_problem(double sigma) {
  Problem problem;
  problem.setup.shape = {7, 5, 2, 0.5};
  problem.setup.lit_face = Face::z_minus;
  problem.patterns = patterns;
  cases::Noise noise(3);
  for (std::size_t i = 0; i < patterns * problem.seen_shape().cells(); ++i) {
    problem.data.push_back(1.0 + noise.uniform() + sigma * noise.normal());
    problem.weight.push_back(i % 11 == 0 ? 0.0 : 1.0 / (sigma * sigma));
  }
  return problem;
}

std::vector<double> clean_prediction(const Problem& problem) {
  cases::Noise noise(3);
  std::vector<double> prediction;
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    prediction.push_back(1.0 + noise.uniform());
    noise.normal();
  }
  return prediction;
}

class DataTermOf : public ::testing::TestWithParam<DataTermOptions> {};

TEST_P(DataTermOf, TaylorRemainderIsOfOrderTwo) {
  const Problem problem = noisy_problem(0.02);
  std::vector<double> at = clean_prediction(problem);
  cases::Noise noise(9);
  std::vector<double> direction;
  for (double& p : at) {
    p *= 1.03;  // off by one and a half sigma and more: every branch of the losses
    direction.push_back(noise.normal());
  }
  const DataTerm term = evaluate(problem, at, GetParam());
  double slope = 0.0;
  for (std::size_t i = 0; i < at.size(); ++i) slope += term.by_prediction[i] * direction[i];
  std::vector<double> remainders;
  for (const double step : {1e-3, 1e-4, 1e-5}) {
    std::vector<double> moved = at;
    for (std::size_t i = 0; i < at.size(); ++i) moved[i] += step * direction[i];
    remainders.push_back(
        std::abs(evaluate(problem, moved, GetParam()).value - term.value - step * slope));
  }
  // Huber's second derivative jumps: residuals that cross over blur the order a little.
  constexpr double blur = 0.2;
  EXPECT_NEAR(std::log10(remainders[0] / remainders[1]), 2.0, blur);
  EXPECT_NEAR(std::log10(remainders[1] / remainders[2]), 2.0, blur);
}

TEST_P(DataTermOf, MaskedDataDoNotCount) {
  Problem problem = noisy_problem(0.02);
  const std::vector<double> prediction = clean_prediction(problem);
  const DataTerm before = evaluate(problem, prediction, GetParam());
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    if (problem.weight[i] == 0.0) problem.data[i] = 1e6;
  }
  const DataTerm after = evaluate(problem, prediction, GetParam());
  EXPECT_EQ(before.value, after.value);
  EXPECT_EQ(before.chi2_per_value, after.chi2_per_value);
  EXPECT_EQ(before.by_prediction, after.by_prediction);
}

DataTermOptions with(Loss loss) {
  DataTermOptions options;
  options.loss = loss;
  return options;
}

INSTANTIATE_TEST_SUITE_P(Losses, DataTermOf,
                         ::testing::Values(with(Loss::gaussian), with(Loss::huber),
                                           with(Loss::student)));

TEST(DataTerm, GaussianLossIsHalfChiSquare) {
  const Problem problem = noisy_problem(0.02);
  const DataTerm term = evaluate(problem, clean_prediction(problem), {});
  EXPECT_NEAR(2.0 * term.value / static_cast<double>(problem.used()), term.chi2_per_value, 1e-12);
  // 95 squares of normal numbers: three standard deviations.
  EXPECT_NEAR(term.chi2_per_value, 1.0, 3.0 * std::sqrt(2.0 / 95.0));
}

TEST(DataTerm, WildDataPullTheGaussianWithoutBoundAndTheOthersNot) {
  Problem problem = noisy_problem(0.02);
  const std::vector<double> prediction = clean_prediction(problem);
  problem.data[5] += 10.0;  // 500 sigma
  const double unit = std::sqrt(problem.weight[5]);
  const auto pull = [&](Loss loss) {
    return -evaluate(problem, prediction, with(loss)).by_prediction[5] / unit;
  };
  EXPECT_GT(pull(Loss::gaussian), 490.0);
  EXPECT_NEAR(pull(Loss::huber), 1.345, 1e-12);
  EXPECT_LT(pull(Loss::student), 0.02);
  // Nor does one wild datum move the robust chi-square.
  EXPECT_GT(evaluate(problem, prediction, {}).chi2_per_value, 1000.0);
  EXPECT_LT(evaluate(problem, prediction, with(Loss::huber)).chi2_per_value, 2.0);
}

}  // namespace
}  // namespace kappamu::inverse
