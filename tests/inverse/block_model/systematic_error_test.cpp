// Systematic error: its size and length are found where they are known, noise alone has none, and
// the choice of model takes it for what it is: blocks that are homogeneous stay so, structure is
// found all the same. Data are of a grid three times as fine as the fitted one.
#include "inverse/block_model/systematic_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "tests/cases/limit_inverse_case.h"
#include "tests/inverse/block_model/systematic_case.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

constexpr int fine = 3;
constexpr double noise = 0.003;

test_cases::Block block(GridShape grid = {20, 16, 8, 0.5}) {
  test_cases::Block b;
  b.grid = grid;
  return b;
}

/// Noise-free values under eight bars.
SurfaceMeasurements expose(const test_cases::Block& b, const test_cases::Figure3& figure) {
  return test_cases::expose_figure(b, figure, test_cases::bar_light(b.grid, 8), fine, 1.3);
}

/// What is found of an error relative to the values, were the values known exactly.
SystematicError found_of(const SurfaceMeasurements& exact, const SurfaceMeasurements& measured) {
  const Problem problem = make_problem(measured, 0, forward::Convention::physical, {});
  const std::vector<double> prediction(exact.value.begin(), exact.value.end());
  const std::vector<double> ratio(prediction.size(), 1.0);
  return estimate_systematic_error(problem, {prediction, ratio});
}

TEST(SystematicError, IsNotFoundInNoise) {
  const SurfaceMeasurements exact = expose(block(), test_cases::even_block(0.35, 0.01));
  int found = 0;
  constexpr int trials = 40;
  for (std::uint64_t seed = 1; seed <= trials; ++seed) {
    SurfaceMeasurements m = exact;
    test_cases::add_noise(m, noise, seed);
    const SystematicError error = found_of(exact, m);
    found += error.found(0.0) ? 1 : 0;
    EXPECT_LT(error.variance, 6.0 * error.variance_error) << seed;
  }
  EXPECT_LE(found, 2) << "beyond three standard deviations, of the best of twenty lengths";
}

TEST(SystematicError, IsFoundOfItsSizeAndLength) {
  const SurfaceMeasurements exact = expose(block(), test_cases::even_block(0.35, 0.01));
  for (const double size : {0.002, 0.005, 0.01}) {
    for (const double length : {1.0, 2.0}) {
      SurfaceMeasurements m = exact;
      test_cases::add_correlated_error(m, size, length, 5);
      test_cases::add_noise(m, noise, 6);
      const SystematicError error = found_of(exact, m);
      std::printf("size %.2g, length %g: found %.3g, %.3g\n", size, length, error.relative,
                  error.length);
      constexpr double fifth = 0.2;
      EXPECT_NEAR(error.relative, size, fifth * size);
      EXPECT_NEAR(error.length, length, fifth * length);
    }
  }
}

TEST(SystematicError, DrawsAreOfTheCovarianceThatIsStated) {
  const SurfaceMeasurements exact =
      expose(block({9, 7, 4, 0.5}), test_cases::even_block(0.35, 0.01));
  SurfaceMeasurements m = exact;
  test_cases::add_noise(m, noise, 1);
  const Problem problem = make_problem(m, 0, forward::Convention::physical, {});
  const std::vector<double> prediction(exact.value.begin(), exact.value.end());
  const ErrorCovariance errors(problem, prediction, {.variance = 2.0, .length = 1.5, .white = 1.2},
                               0.004);
  // Σ by draws, through a direction that is large in places.
  Eigen::MatrixXd direction(static_cast<Eigen::Index>(problem.data.size()), 2);
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    rows.push_back(i);
    direction(static_cast<Eigen::Index>(i), 0) = std::sin(0.3 * static_cast<double>(i));
    direction(static_cast<Eigen::Index>(i), 1) = i % 9 < 3 ? 1.0 : -0.2;
  }
  const Eigen::MatrixXd stated = errors.between(direction, rows);
  Eigen::MatrixXd sampled = Eigen::MatrixXd::Zero(2, 2);
  constexpr int draws = 4000;
  std::mt19937_64 engine(3);
  for (int k = 0; k < draws; ++k) {
    const std::vector<double> s = errors.draw(engine);
    const Eigen::Vector2d along =
        direction.transpose() *
        Eigen::Map<const Eigen::VectorXd>(s.data(), static_cast<Eigen::Index>(s.size()));
    sampled += along * along.transpose() / draws;
  }
  constexpr double five_errors = 0.11;  // 5 √(2/4000)
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(sampled(k, k) / stated(k, k), 1.0, five_errors);
}

/// The model that a fit chooses, without the volume's descent.
FitReport choose(const test_cases::Figure3& figure, double size, std::uint64_t seed,
                 const test_cases::Block& b = block()) {
  SurfaceMeasurements m = expose(b, figure);
  if (size > 0.0) test_cases::add_rig_error(m, size, seed);
  test_cases::add_noise(m, noise, seed + 1000);
  FitOptions options;
  options.path.stage_steps = 1;
  options.path.max_levels = 2;
  options.uncertainty.probes = 0;
  return cases::fit(m, options).report;
}

TEST(SystematicError, LeavesHomogeneousBlocksHomogeneous) {
  int right = 0;
  int blocks = 0;
  for (const double size : {0.001, 0.003, 0.01}) {
    for (std::uint64_t seed = 101; seed <= 107; ++seed, ++blocks) {
      test_cases::Noise chance(seed + static_cast<std::uint64_t>(1e6 * size));
      const double kappa = 0.2 * std::exp(0.4 * chance.normal());
      const double mu = 0.02 * std::exp(0.5 * chance.normal());
      const FitReport report = choose(test_cases::even_block(kappa, mu), size, seed);
      right += report.model.model == Model::homogeneous ? 1 : 0;
      if (size == 0.01) {
        EXPECT_GT(report.model.systematic, 0.001) << seed;
        EXPECT_LT(report.model.systematic, 0.02) << seed;
      }
      std::printf("%.2g %%, seed %d: %s\n", 100.0 * size, static_cast<int>(seed),
                  report.model.reason.c_str());
    }
  }
  EXPECT_GE(right, 0.95 * blocks);
}

TEST(SystematicError, HidesNoFaintInclusions) {
  // A tenth more and less of κ leaves 0.9 % of the light unexplained, no more than an error may.
  for (const double size : {0.0, 0.003, 0.006}) {
    const FitReport report = choose(test_cases::inclusions(0.25, 0.02, 1.1), size, 111);
    EXPECT_EQ(report.model.model, Model::volume) << size << ": " << report.model.reason;
  }
}

TEST(SystematicError, HidesNoStructure) {
  for (const double size : {0.0, 0.003, 0.01}) {
    for (std::uint64_t seed = 101; seed <= 103; ++seed) {
      const FitReport layers = choose(test_cases::random_layers(0.25, 0.03, seed), size, seed);
      std::printf("%.2g %%: %s\n", 100.0 * size, layers.model.reason.c_str());
      EXPECT_EQ(layers.model.model, Model::layered) << size << " seed " << seed;
      const FitReport inside = choose(test_cases::inclusions(0.25, 0.02, 2.0), size, seed);
      std::printf("%.2g %%: %s\n", 100.0 * size, inside.model.reason.c_str());
      EXPECT_EQ(inside.model.model, Model::volume) << size << " seed " << seed;
    }
  }
}

}  // namespace
}  // namespace kappamu::inverse
