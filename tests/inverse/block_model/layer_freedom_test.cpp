// What light leaves open of the profile along the depth.
#include "inverse/block_model/layer_freedom.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "inverse/fit/fit_options.h"
#include "inverse/problem/problem.h"
#include "tests/cases/inverse_case.h"
#include "tests/cases/media.h"

namespace kappamu::inverse {
namespace {

/// Even light, and three phases of one sinusoid along either axis.
std::vector<double> sinusoid_light(const test_cases::Block& block) {
  const FaceShape face = face_shape(block.grid, block.lit);
  constexpr double period = 8.0;  // voxels
  std::vector<double> light(face.cells(), 1.0);
  for (const bool along_u : {true, false}) {
    for (int phase = 0; phase < 3; ++phase) {
      for (int v = 0; v < face.nv; ++v) {
        for (int u = 0; u < face.nu; ++u) {
          const double at = ((along_u ? u : v) + 0.5) / period + phase / 3.0;
          light.push_back(0.5 + 0.5 * std::cos(2.0 * std::numbers::pi * at));
        }
      }
    }
  }
  return light;
}

/// With its solves on the block's grid, or on voxels of twice the edge.
enum class Solves { fine, coarse };
LayerFreedom freedom_under(const test_cases::Block& block, const std::vector<double>& light,
                           Solves solves = Solves::fine) {
  const GridShape fine = block.grid.refined(2);
  const CoefficientPair truth{std::vector<double>(fine.cells(), std::log(0.2)),
                              std::vector<double>(fine.cells(), std::log(0.01))};
  SurfaceMeasurements data = test_cases::expose(block, truth, light);
  for (std::size_t i = 0; i < data.value.size(); ++i) {
    data.variance[i] = static_cast<float>(1e-4 * data.value[i] * data.value[i]);
  }
  data.smooth_error = {0.003, 0.003};
  const FitOptions options;
  Problem problem = make_problem(data, 0, options.data.convention, options.data.model_error);
  const MediumSpace space = problem.space();
  if (solves == Solves::coarse) problem = coarsen(problem, options.data.model_error);
  Objective objective(std::move(problem), {});
  objective.count_all_errors();
  const std::size_t cells = objective.space().cells();
  objective.value(
      {std::vector<double>(cells, std::log(0.2)), std::vector<double>(cells, std::log(0.01))});
  return layer_freedom(objective, space);
}

TEST(LayerFreedom, LightOfOneSinusoidOnTheSeenFaceLeavesTheProfileOpen) {
  test_cases::Block block;
  block.grid = {16, 16, 8, 0.5};
  block.seen = block.lit;
  const LayerFreedom sinusoid = freedom_under(block, sinusoid_light(block));
  const LayerFreedom bars = freedom_under(block, test_cases::bar_light(block.grid, block.lit, 4));
  ASSERT_EQ(sinusoid.log_mu.size(), 8U);
  EXPECT_GT(sinusoid.least_log_mu(), bars.least_log_mu());
  for (const LayerFreedom* found : {&sinusoid, &bars}) {
    // κ of the face that is seen is known, that of the other side is not.
    EXPECT_LT(found->log_kappa.front(), 0.1);
    EXPECT_GT(found->log_kappa.back(), 0.3);
  }
}

/// Layers may end within coarse voxels: three voxels of depth, of which a coarse one has two. What
/// pixels of half the size know of κ next to the seen face is lost there, so more is left open.
TEST(LayerFreedom, OnVoxelsOfTwiceTheEdgeIsNoSmaller) {
  test_cases::Block block;
  block.grid = {24, 24, 18, 0.5};
  const std::vector<double> light = test_cases::bar_light(block.grid, block.lit, 4);
  const LayerFreedom fine = freedom_under(block, light);
  const LayerFreedom coarse = freedom_under(block, light, Solves::coarse);
  ASSERT_EQ(coarse.log_mu.size(), fine.log_mu.size());
  constexpr double share = 0.2;
  for (std::size_t slice = 0; slice < fine.log_mu.size(); ++slice) {
    EXPECT_GT(coarse.log_kappa[slice], (1.0 - share) * fine.log_kappa[slice]);
    EXPECT_NEAR(coarse.log_mu[slice], fine.log_mu[slice], share * fine.log_mu[slice]);
  }
}

TEST(LayerFreedom, OfSeveralChannelsTheLargerOneCounts) {
  LayerFreedom both;
  both.widen({{0.1, 0.4}, {1.0, 2.0}});
  both.widen({{0.2, 0.3}, {0.5, 3.0}});
  EXPECT_EQ(both.log_kappa, (std::vector<double>{0.2, 0.4}));
  EXPECT_EQ(both.log_mu, (std::vector<double>{1.0, 3.0}));
  EXPECT_EQ(both.least_log_mu(), 1.0);
  EXPECT_EQ(LayerFreedom{}.least_log_mu(), 0.0);
}

}  // namespace
}  // namespace kappamu::inverse
