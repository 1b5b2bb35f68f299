// Which grids a fit descends through, and what goes from one to the next.
#include "inverse/problem/grid_levels.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kappamu::inverse {
namespace {

Problem lit_block(const GridShape& shape) {
  Problem p;
  p.setup.shape = shape;
  p.patterns = 1;
  p.irradiance.assign(p.lit_shape().cells(), 1.0);
  p.data.assign(p.seen_shape().cells(), 1.0);
  p.weight.assign(p.data.size(), 4.0);
  return p;
}

GridLevels levels_of(const Problem& problem, DataWeights weights = DataWeights::by_variance) {
  return {problem, ModelError{}, weights, 4};
}

TEST(GridLevels, HalveUntilAnAxisWouldHaveFewerThanFourVoxels) {
  const GridLevels levels = levels_of(lit_block({33, 20, 16, 0.5}));
  ASSERT_EQ(levels.count(), 3);
  EXPECT_EQ(levels[1].setup.shape, (GridShape{17, 10, 8, 1.0}));
  EXPECT_EQ(levels[2].setup.shape, (GridShape{9, 5, 4, 2.0}));
  EXPECT_EQ(levels_of(lit_block({33, 20, 7, 0.5})).count(), 1);
}

TEST(GridLevels, AreNoMoreThanAskedFor) {
  EXPECT_EQ(GridLevels(lit_block({64, 64, 64, 0.5}), {}, DataWeights::by_variance, 2).count(), 2);
}

TEST(GridLevels, EndWhereMasksLeaveTooFewWholeData) {
  Problem masked = lit_block({16, 16, 16, 0.5});
  for (std::size_t i = 0; i < masked.weight.size(); i += 2) masked.weight[i] = 0.0;
  EXPECT_EQ(levels_of(masked).count(), 1) << "no coarse datum covers four used ones";
}

TEST(GridLevels, EqualWeightsHoldOnEveryGrid) {
  Problem problem = lit_block({16, 16, 16, 0.5});
  for (std::size_t i = 0; i < problem.weight.size(); ++i) {
    problem.weight[i] = 1.0 + static_cast<double>(i % 5);
  }
  problem.smooth_error = {1e-4, 1e-4};
  const GridLevels levels(problem, {0.03, 3e-3}, DataWeights::equal, 4);
  const auto equal = [](const Problem& grid) {
    const std::vector<double>& weight = grid.weight;
    return std::equal(weight.begin() + 1, weight.end(), weight.begin());
  };
  for (int level = 0; level < levels.count(); ++level) EXPECT_TRUE(equal(levels[level])) << level;
  ASSERT_NE(levels.closer(), nullptr);
  EXPECT_TRUE(equal(*levels.closer()));
}

TEST(GridLevels, TheLastCoarseGridIsThereOnceMoreWithAThirdOfItsModelError) {
  Problem problem = lit_block({16, 16, 16, 0.5});
  problem.data.assign(problem.data.size(), 2.0);
  problem.smooth_error = {1e-4, 1e-4};
  const GridLevels exact = levels_of(problem);
  const GridLevels levels(problem, {0.03, 0.0}, DataWeights::by_variance, 4);
  ASSERT_NE(levels.closer(), nullptr);
  EXPECT_EQ(levels.closer()->setup.shape, levels[1].setup.shape);
  EXPECT_EQ(levels.closer()->data, levels[1].data);
  for (std::size_t i = 0; i < levels[1].weight.size(); ++i) {
    const double stated = 1.0 / exact[1].weight[i];
    EXPECT_NEAR(1.0 / levels[1].weight[i] - stated,
                9.0 * (1.0 / levels.closer()->weight[i] - stated), 1e-12);
  }
  EXPECT_EQ(exact.closer(), nullptr) << "no model error";
  const ModelError error{0.03, 0.0};
  EXPECT_EQ(GridLevels(problem, error, DataWeights::by_variance, 2).closer(), nullptr);
  problem.smooth_error = {};
  EXPECT_EQ(GridLevels(problem, error, DataWeights::by_variance, 4).closer(), nullptr);
}

TEST(GridLevels, RefineToTheNextFinerGridAndTheFinestToItsOwnHalf) {
  const GridLevels levels = levels_of(lit_block({16, 12, 8, 0.5}));
  ASSERT_EQ(levels.count(), 2);
  EXPECT_EQ(levels.refinement(1).setup.shape, levels[0].setup.shape);
  EXPECT_EQ(levels.refinement(1).irradiance, levels[0].irradiance);
  EXPECT_EQ(levels.refinement(0).setup.shape, (GridShape{32, 24, 16, 0.25}));
}

TEST(GridLevels, EvenFieldsStayEvenOnTheFinerGrid) {
  const GridLevels levels = levels_of(lit_block({15, 12, 8, 0.5}));
  const auto even = [](const Problem& problem) {
    const std::size_t cells = problem.setup.shape.cells();
    return CoefficientPair{std::vector<double>(cells, -0.5), std::vector<double>(cells, -3.0)};
  };
  EXPECT_EQ(levels.to_finer(even(levels[1]), 1), even(levels[0]));
}

}  // namespace
}  // namespace kappamu::inverse
