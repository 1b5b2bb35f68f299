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

  GridPath path(GridCorrection correction, float noise = 1.0F) const {
    SurfaceMeasurements m = cases::measure(block, cases::smooth_medium(block.grid.refined(2)), 2);
    for (float& variance : m.variance) variance *= noise * noise;
    Problem problem = make_problem(m, 0, forward::Convention::physical, {});
    return {
        GridLevels(std::move(problem), {}, DataWeights::by_variance, 4), backend, {}, correction};
  }
  static CoefficientPair even(const GridShape& shape) {
    return {std::vector<double>(shape.cells(), -1.5), std::vector<double>(shape.cells(), -4.0)};
  }

  bench::Block block;
  Backend backend;
};

TEST_F(GridPathTest, GoesToTheFinestGridWithItsFieldsAndItsCountOfSolves) {
  GridPath grid = path(GridCorrection::next_finer);
  ASSERT_EQ(grid.levels().coarsest(), 1);
  grid.open(1);
  EXPECT_EQ(grid.shape(), (GridShape{5, 4, 4, 1.0}));
  EXPECT_DOUBLE_EQ(grid.thickness_mm(), 4.0);
  EXPECT_EQ(grid.objective().solves().total(), 0);
  grid.renew_correction(even(grid.shape()));
  const SolveCount solves = grid.objective().solves();
  EXPECT_GT(solves.refined, 0);

  EXPECT_EQ(grid.refine(even(grid.shape())), even(block.grid));
  EXPECT_EQ(grid.level(), 0);
  EXPECT_EQ(grid.shape(), block.grid);
  EXPECT_DOUBLE_EQ(grid.thickness_mm(), 4.0);
  EXPECT_EQ(grid.objective().solves().total(), solves.total());
  EXPECT_EQ(grid.objective().solves().voxel_iterations, solves.voxel_iterations);
  for (const double r : grid.objective().correction().ratio) {
    ASSERT_EQ(r, 1.0) << "the coarse grid's r is not this one's";
  }
}

TEST_F(GridPathTest, TheCorrectionMakesACoarseGridPredictAsTheNextFinerOne) {
  GridPath grid = path(GridCorrection::next_finer);
  grid.open(0);
  const double fine = grid.objective().value(even(grid.shape()));
  const double fine_chi2 = grid.objective().chi2_per_value();
  ASSERT_TRUE(std::isfinite(fine));
  grid.open(1);
  const CoefficientPair fields = even(grid.shape());
  grid.objective().value(fields);
  const double uncorrected = grid.objective().chi2_per_value();
  const double corrected = grid.renew_correction(fields);
  EXPECT_EQ(corrected, grid.objective().chi2_per_value());
  EXPECT_LT(std::abs(corrected / fine_chi2 - 1.0), 0.5 * std::abs(uncorrected / fine_chi2 - 1.0));
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

}  // namespace
}  // namespace kappamu::inverse
