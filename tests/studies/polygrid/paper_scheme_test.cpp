// The paper's scheme on polygrids: its weights, and how many nodes its relaxations process beside
// ours (figure 15 of [W]).
#include <gtest/gtest.h>

#include <cstdio>
#include <random>

#include "core/optics.h"
#include "forward/polygrid/opencl/opencl_solver.h"
#include "studies/polygrid/relaxation.h"
#include "tests/cases/made_polygrid.h"
#include "tests/cases/polygrid_reference.h"

namespace kappamu::studies {
namespace {

using Eigen::Vector3d;

const double A = boundary_constants(1.3).A;

TEST(PolygridWeights, AreExactForSquaresOnABox) {
  const NodeGrid grid = node_grid(box_polygrid({5, 4, 6}, {2.0, 1.5, 3.0}));
  const LaplacianWeights weights = laplacian_weights(grid, NegativeWeights::kept);
  EXPECT_EQ(weights.negative, 0);
  EXPECT_EQ(weights.ill_conditioned, 0);
  const auto f = [](const Vector3d& p) {
    return p[0] * p[0] + 2.0 * p[1] * p[1] - 0.5 * p[2] * p[2] + p[0] - 3.0 * p[2];
  };
  for (std::size_t k = 0; k < grid.node.size(); ++k) {
    double laplacian = 0.0;
    for (std::size_t s = 0; s < 6; ++s) {
      const int link = grid.link[k][s];
      const Vector3d& beside = link >= 0 ? grid.node[static_cast<std::size_t>(link)]
                                         : grid.boundary_node[static_cast<std::size_t>(~link)];
      laplacian += weights.weight[k][s] * (f(beside) - f(grid.node[k]));
    }
    EXPECT_NEAR(laplacian, 5.0, 1e-9);
  }
}

// Links that lean on each other have negative weights; a flux form takes their place.
TEST(PolygridWeights, AreReplacedWhereNegative) {
  Polygrid grid = bent_polygrid({8, 6, 5});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> shift(-0.15, 0.15);
  for (Vector3d& node : grid.node) node += Vector3d(shift(random), shift(random), shift(random));
  const LaplacianWeights kept = laplacian_weights(node_grid(grid), NegativeWeights::kept);
  const LaplacianWeights replaced = laplacian_weights(node_grid(grid));
  EXPECT_GT(kept.negative, 0);
  EXPECT_EQ(kept.negative, replaced.negative);
  int still = 0, were = 0;
  for (std::size_t k = 0; k < grid.node.size(); ++k) {
    for (const double w : replaced.weight[k]) still += w < 0.0;
    bool any = false;
    for (const double w : kept.weight[k]) any = any || w < 0.0;
    were += any;
  }
  EXPECT_EQ(still, 0);
  EXPECT_EQ(were, kept.negative);
}

TEST(PolygridWeights, CoarserLevelsHaveTheirChildrensMeans) {
  NodeGrid fine = node_grid(box_polygrid({6, 4, 8}, {6, 4, 8}));
  const NodeGrid coarse = coarser(fine), expected = node_grid(box_polygrid({3, 2, 4}, {6, 4, 8}));
  ASSERT_EQ(coarse.node.size(), expected.node.size());
  for (std::size_t k = 0; k < coarse.node.size(); ++k) {
    EXPECT_LE((coarse.node[k] - expected.node[k]).norm(), 1e-12);
  }
  EXPECT_EQ(coarse.boundary_node.size(), expected.boundary_node.size());
}

/// A cube with light on one side: the paper's relaxations and ours, each against its own converged
/// answer, as figure 15 has it.
struct Trial {
  static constexpr int n = 16;
  /// Σ (L − L₀)²/Σ L₀²: the paper's, and 0.3 % of L.
  static constexpr double papers_target = 5e-3, target = 1e-5;
  Polygrid grid = box_polygrid({n, n, n}, {10, 10, 10});
  std::vector<Coefficients> of_cell =
      std::vector<Coefficients>(grid.cell.size(), Coefficients{0.3, 0.003});
  std::vector<double> q = lit();
  std::vector<RelaxationLevel> levels = relaxation_levels(grid, of_cell, q, 3);

  std::vector<double> lit() const {
    std::vector<double> result;
    for (const Vector3d& p : grid.boundary_node) result.push_back(p[2] > 9.99 ? 1.0 : 0.0);
    return result;
  }
  NodeFluence dark(const RelaxationLevel& level) const {
    return {std::vector<double>(level.grid.node.size(), 0.0),
            std::vector<double>(level.grid.boundary_node.size(), 0.0)};
  }
  /// Of L = φ − q, up to a factor.
  double error(const NodeFluence& at, const NodeFluence& exact) const {
    double difference = 0.0, size = 0.0;
    for (std::size_t b = 0; b < q.size(); ++b) {
      difference += std::pow(at.boundary[b] - exact.boundary[b], 2);
      size += std::pow(exact.boundary[b] - q[b], 2);
    }
    return difference / size;
  }
  /// Nodes processed, `processed` before, until the error is below `wanted`; 0: never.
  std::size_t until_target(NodeFluence fluence, int depth, std::size_t processed,
                           const NodeFluence& exact, double wanted) const {
    std::size_t reached = 0;
    for (int step = 0; step < 4000 && reached == 0; ++step) {
      relax(levels[0], A, 1, depth, fluence, [&](std::size_t nodes) { processed += nodes; });
      if (error(fluence, exact) <= wanted) reached = processed;
    }
    return reached;
  }
};

TEST(PolygridRelaxation, CoarseLevelsSaveNodesAndOursMore) {
  const Trial trial;
  NodeFluence exact = trial.dark(trial.levels[0]);
  relax(trial.levels[0], A, 4000, 0, exact, {});
  const std::size_t plain =
      trial.until_target(trial.dark(trial.levels[0]), 0, 0, exact, Trial::target);
  // From the coarsest level on, 60 steps each.
  std::size_t processed = 0;
  const auto count = [&](std::size_t nodes) { processed += nodes; };
  NodeFluence fluence = trial.dark(trial.levels[2]);
  relax(trial.levels[2], A, 60, 0, fluence, count);
  fluence = from_coarser(trial.levels[1], fluence);
  relax(trial.levels[1], A, 60, 0, fluence, count);
  fluence = from_coarser(trial.levels[0], fluence);
  const std::size_t hierarchical = trial.until_target(fluence, 0, processed, exact, Trial::target);
  const std::size_t coarse_target =
      trial.until_target(fluence, 0, processed, exact, Trial::papers_target);
  const std::size_t adaptive =
      trial.until_target(fluence, 4, processed, exact, Trial::papers_target);
  ASSERT_GT(plain, 0U);
  ASSERT_GT(hierarchical, 0U);
  EXPECT_LT(2 * hierarchical, plain);
  EXPECT_GT(adaptive, 0U);
  EXPECT_LE(adaptive, coarse_target);

  // The relaxation's converged answer is ours within its own discretisation.
  const Equations equations(trial.grid, A);
  const auto solver = make_reference_solver(equations);
  solver->set_media({equations.values(trial.of_cell)});
  std::vector<double> load(equations.unknowns(), 0.0);
  for (std::size_t b = 0; b < trial.q.size(); ++b) {
    for (const int c : boundary_corners(trial.grid, b)) {
      load[static_cast<std::size_t>(c)] += 0.25 * trial.grid.area[b] * trial.q[b] / (2.0 * A);
    }
  }
  const auto boundary_means = [&](const std::vector<double>& at_corners) {
    NodeFluence result = exact;
    for (std::size_t b = 0; b < trial.q.size(); ++b) {
      result.boundary[b] = 0.0;
      for (const int c : boundary_corners(trial.grid, b)) {
        result.boundary[b] += 0.25 * at_corners[static_cast<std::size_t>(c)];
      }
    }
    return result;
  };
  std::vector<std::vector<double>> x;
  solver->solve({{0, load}}, x, 1e-8, 2000);
  const NodeFluence converged = boundary_means(x[0]);
  EXPECT_LE(trial.error(exact, converged), 0.05 * 0.05);

  // Ours: a row of 27 counts as four nodes of six links, a V-cycle passes every level twice.
  const Hierarchy hierarchy(equations, trial.grid);
  const auto multigrid =
      make_opencl_solver(equations, hierarchy, device::Context::chosen("auto"), Precision::single);
  multigrid->set_media({equations.values(trial.of_cell)});
  std::size_t per_iteration = 4 * equations.unknowns(), ours = 0;
  for (const GraphLevel& level : hierarchy.level()) per_iteration += 2 * level.links.rows();
  for (int iterations = 1; iterations < 40 && ours == 0; ++iterations) {
    std::vector<std::vector<double>> y;
    multigrid->solve({{0, load}}, y, 1e-9, iterations);
    if (trial.error(boundary_means(y[0]), converged) <= Trial::target) {
      ours = static_cast<std::size_t>(iterations) * per_iteration;
    }
  }
  ASSERT_GT(ours, 0U);
  EXPECT_LT(ours, hierarchical);
  std::printf(
      "nodes processed: plain %zu, hierarchical %zu, ours %zu; to 0.5 %%: hierarchical %zu, "
      "adaptive "
      "%zu\n",
      plain, hierarchical, ours, coarse_target, adaptive);
}

}  // namespace
}  // namespace kappamu::studies
