// What a fit takes with it from a grid to the next finer one, and what it makes anew there.
#include "inverse/problem/grid_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

/// 9 × 8 × 8 voxels, so that the coarser grid is thicker along no axis but the first.
class GridPathTest : public testing::Test {
 protected:
  GridPathTest() {
    block.grid = {9, 8, 8, 0.5};
    backend.device = "reference";
  }

  GridPath path(GridCorrection correction, float noise = 1.0F,
                const ModelError& coarse_error = {}) const {
    SurfaceMeasurements m = cases::measure(block, cases::smooth_medium(block.grid.refined(2)), 2);
    for (float& variance : m.variance) variance *= noise * noise;
    if (coarse_error.relative > 0.0) m.smooth_error = {1e-4, 1e-4};
    Problem problem = make_problem(m, 0, forward::Convention::physical, {});
    return {GridLevels(std::move(problem), coarse_error, DataWeights::by_variance, 4),
            backend,
            {},
            correction};
  }
  static CoefficientPair even(const GridShape& shape) {
    return {std::vector<double>(shape.cells(), -1.5), std::vector<double>(shape.cells(), -4.0)};
  }

  test_cases::Block block;
  Backend backend;
};

TEST_F(GridPathTest, GoesToTheFinestGridWithItsFieldsAndItsCountOfSolves) {
  GridPath grid = path(GridCorrection::next_finer);
  ASSERT_EQ(grid.levels().coarsest(), 1);
  grid.open(1);
  EXPECT_EQ(grid.shape(), (GridShape{5, 4, 4, 1.0}));
  EXPECT_DOUBLE_EQ(grid.space().thickness_mm, 4.0);
  EXPECT_EQ(grid.objective().solves().total(), 0);
  grid.renew_correction(even(grid.shape()));
  const SolveCount solves = grid.objective().solves();
  EXPECT_GT(solves.refined, 0);

  EXPECT_EQ(grid.refine(even(grid.shape())), even(block.grid));
  EXPECT_EQ(grid.level(), 0);
  EXPECT_EQ(grid.shape(), block.grid);
  EXPECT_DOUBLE_EQ(grid.space().thickness_mm, 4.0);
  EXPECT_EQ(grid.objective().solves().total(), solves.total());
  EXPECT_EQ(grid.objective().solves().voxel_iterations, solves.voxel_iterations);
  for (const double r : grid.objective().correction().ratio) {
    ASSERT_EQ(r, 1.0) << "the coarse grid's r is not this one's";
  }
}

TEST_F(GridPathTest, TheCorrectionMakesACoarseGridPredictAsTheNextFinerOne) {
  backend.precision = forward::Precision::double_precision;
  backend.solve.tolerance = backend.refined_tolerance = 1e-9;
  GridPath grid = path(GridCorrection::next_finer, 1e-6F);
  grid.open(0);
  const FaceShape fine_face = grid.problem().seen_shape();
  grid.objective().value(even(grid.shape()));
  const std::vector<double> fine = grid.objective().prediction();
  grid.open(1);
  const CoefficientPair fields = even(grid.shape());
  const std::vector<double> expected =
      restrict_face(fine, fine_face, grid.problem().seen_shape(), 2, grid.problem().patterns);
  const auto largest_error = [&] {
    double error = 0.0;
    const std::vector<double> prediction = grid.objective().prediction();
    for (std::size_t i = 0; i < expected.size(); ++i) {
      error = std::max(error, std::abs(prediction[i] / expected[i] - 1.0));
    }
    return error;
  };
  grid.objective().value(fields);
  const double uncorrected = largest_error();
  const double chi2 = grid.renew_correction(fields);
  EXPECT_EQ(chi2, grid.objective().chi2_per_value());
  constexpr double of_solves = 1e-6;  // to a residual of 1e-9
  EXPECT_LT(largest_error(), of_solves);
  EXPECT_GT(uncorrected, 1e-2);
}

TEST_F(GridPathTest, FitsTheLastCoarseGridCloserOnceWithTheSameCorrection) {
  block.grid = {17, 16, 16, 0.5};
  GridPath grid = path(GridCorrection::next_finer, 1.0F, {0.03, 3e-3});
  grid.open(1);
  const CoefficientPair fields = even(grid.shape());
  const double chi2 = grid.renew_correction(fields);
  const Correction correction = grid.objective().correction();
  const SolveCount solves = grid.objective().solves();

  ASSERT_TRUE(grid.go_closer());
  EXPECT_TRUE(grid.closer());
  EXPECT_EQ(grid.level(), 1);
  EXPECT_EQ(grid.objective().correction().ratio, correction.ratio);
  EXPECT_EQ(grid.objective().solves().total(), solves.total());
  grid.objective().value(fields);
  EXPECT_GT(grid.objective().chi2_per_value(), 2.0 * chi2);
  EXPECT_FALSE(grid.go_closer()) << "once is enough";

  EXPECT_EQ(grid.refine(fields), even(block.grid));
  EXPECT_EQ(grid.level(), 0);
  EXPECT_FALSE(grid.closer());
  EXPECT_FALSE(grid.go_closer()) << "the finest grid has no other";
}

TEST_F(GridPathTest, WithoutACorrectionNothingIsSolvedOnAFinerGrid) {
  GridPath grid = path(GridCorrection::none);
  grid.open(1);
  const CoefficientPair fields = even(grid.shape());
  const double chi2 = grid.renew_correction(fields);
  EXPECT_EQ(grid.objective().solves().refined, 0);
  EXPECT_EQ(grid.objective().solves().forward, 1);
  EXPECT_EQ(chi2, grid.objective().chi2_per_value());
}

TEST_F(GridPathTest, NoisyDataAreSolvedMoreLoosely) {
  backend.solve.tolerance = 1e-9;
  GridPath precise = path(GridCorrection::none, 1e-4F);
  GridPath noisy = path(GridCorrection::none, 10.0F);
  precise.open(0);
  noisy.open(0);
  precise.objective().value(even(block.grid));
  noisy.objective().value(even(block.grid));
  EXPECT_LT(noisy.objective().solves().voxel_iterations,
            0.7 * precise.objective().solves().voxel_iterations);
}

TEST_F(GridPathTest, DerivativesAreSolvedMoreLooselyThanTheLight) {
  backend.solve.tolerance = 1e-9;
  GridPath grid = path(GridCorrection::none, 1e-4F);
  grid.open(0);
  Objective& loose = grid.objective();
  loose.value(even(block.grid));
  const double light = loose.solves().voxel_iterations;
  const CoefficientPair found = loose.gradient();
  EXPECT_LT(loose.solves().voxel_iterations - light, 0.7 * light);

  Objective exact(grid.problem(), backend);
  exact.value(even(block.grid));
  const CoefficientPair expected = exact.gradient();
  double error = 0.0, square = 0.0;
  for (std::size_t i = 0; i < expected.log_mu.size(); ++i) {
    error += std::pow(found.log_kappa[i] - expected.log_kappa[i], 2) +
             std::pow(found.log_mu[i] - expected.log_mu[i], 2);
    square += std::pow(expected.log_kappa[i], 2) + std::pow(expected.log_mu[i], 2);
  }
  constexpr double of_solves = 0.02;  // grid_path.cpp: the residual of adjoint solves
  EXPECT_LT(std::sqrt(error / square), of_solves);
}

}  // namespace
}  // namespace kappamu::inverse
