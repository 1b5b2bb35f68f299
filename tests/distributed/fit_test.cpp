// What is minimised by pieces is what a whole block's fit minimises, and so is its minimum.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "inverse/distributed/distributed_fit.h"

namespace kappamu::inverse::distributed {
namespace {

using forward::distributed::Box;

/// A block with a dense core, measured with noise of 1 %.
SurfaceMeasurements measured() {
  SurfaceMeasurements m;
  m.grid = {12, 10, 6, 0.5};
  m.channels = {"grey"};
  m.patterns = 5;
  std::mt19937_64 random(4711);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  m.irradiance.resize(m.lit_shape().cells() * 5);
  for (float& e : m.irradiance) e = unit(random) < 0.4F ? 1.0F : 0.1F;
  const auto op =
      forward::block_operators()->make(make_setup(m, {}), m.seen_face, "reference", {}).op;
  std::vector<double> kappa(m.grid.cells(), 0.25), mu(m.grid.cells(), 0.01);
  for (int z = 2; z < 5; ++z) {
    for (int y = 3; y < 6; ++y) {
      for (int x = 5; x < 9; ++x) {
        kappa[m.grid.index(x, y, z)] = 0.1;
        mu[m.grid.index(x, y, z)] = 0.03;
      }
    }
  }
  op->set_medium(kappa, mu);
  const std::vector<double> light(m.irradiance.begin(), m.irradiance.end());
  for (const double value : solve_exitance(*op, light, m.patterns, 8, {1e-10, 500})) {
    const double deviation = 0.01 * value;
    m.value.push_back(static_cast<float>(value + deviation * normal(random)));
    m.variance.push_back(static_cast<float>(deviation * deviation));
  }
  return m;
}

/// Of the piece's faces, z ones here.
SurfaceMeasurements of_piece(const BlockPieces& pieces, const SurfaceMeasurements& m) {
  const Box& held = pieces.held();
  const auto cut = [&](const std::vector<float>& maps) {
    std::vector<float> part;
    for (int k = 0; k < m.patterns; ++k) {
      for (int y = held.begin[1]; y < held.end[1]; ++y) {
        for (int x = held.begin[0]; x < held.end[0]; ++x) {
          part.push_back(maps[(static_cast<std::size_t>(k) * m.grid.ny + y) * m.grid.nx + x]);
        }
      }
    }
    return part;
  };
  SurfaceMeasurements piece = m;
  piece.grid = pieces.piece().shape;
  piece.irradiance = cut(m.irradiance);
  piece.value = cut(m.value);
  piece.variance = cut(m.variance);
  return piece;
}

FitOptions by_weight(double weight) {
  FitOptions options;
  options.regulariser.kind = RegulariserKind::h1;
  options.path.model = Model::volume;
  options.path.correct_grid = false;
  options.path.max_levels = 1;
  options.path.weight = weight;
  options.path.stage_tolerance = options.path.final_tolerance = 1e-9;
  options.uncertainty.probes = 0;
  options.solver.backend.device = "reference";
  options.solver.backend.precision = forward::Precision::double_precision;
  options.solver.backend.solve = {1e-9, 500};
  return options;
}

class PieceFits : public testing::Test {
 protected:
  const SurfaceMeasurements whole = measured();
  const std::shared_ptr<const BlockPieces> pieces =
      std::make_shared<BlockPieces>(PETSC_COMM_WORLD, make_setup(whole, {}));
  const FitOptions options = by_weight(3000.0);
  const Problem problem =
      piece_problem(*pieces, of_piece(*pieces, whole), {}, options.data.model_error);

  /// f(voxel of the piece, the rank's own number of it, voxel of the block)
  template <class F>
  void for_own(F f) const {
    const GridShape& piece = pieces->piece().shape;
    const auto& first = pieces->held().begin;
    pieces->for_own([&](std::size_t i, std::size_t k) {
      const auto nx = static_cast<std::size_t>(piece.nx), ny = static_cast<std::size_t>(piece.ny);
      f(i, k,
        whole.grid.index(static_cast<int>(i % nx) + first[0],
                         static_cast<int>(i / nx % ny) + first[1], static_cast<int>(i / nx / ny)));
    });
  }
};

TEST_F(PieceFits, ObjectiveAndGradientAreThoseOfTheWholeBlock) {
  const double weight = 7.0;
  const Anchor anchor{std::log(0.2), std::log(0.01), 30.0};
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  CoefficientPair fields{std::vector<double>(whole.grid.cells()), {}};
  for (double& x : fields.log_kappa) x = anchor.log_kappa + 0.3 * normal(random);
  for (std::size_t i = 0; i < whole.grid.cells(); ++i) {
    fields.log_mu.push_back(anchor.log_mu + 0.3 * normal(random));
  }
  Objective objective(make_problem(whole, 0, {}, options.data.model_error), options.solver.backend);
  const Roughness rough = roughness(objective.space(), fields, anchor);
  const double expected = objective.value(fields) + weight * rough.value;
  const CoefficientPair slope = objective.gradient();

  PieceObjective by_pieces(pieces, problem, options.solver.backend, anchor);
  by_pieces.set_weight(weight);
  const std::size_t own = pieces->owned().cells();
  std::vector<double> x(2 * own), gradient(2 * own);
  for_own([&](std::size_t, std::size_t k, std::size_t i) {
    x[k] = fields.log_kappa[i];
    x[own + k] = fields.log_mu[i];
  });
  EXPECT_NEAR(by_pieces.value(x), expected, 1e-7 * expected);
  EXPECT_NEAR(by_pieces.chi2_per_value(), objective.chi2_per_value(),
              1e-7 * objective.chi2_per_value());
  by_pieces.gradient(gradient);
  double error = 0.0, norm = 0.0;
  for_own([&](std::size_t, std::size_t k, std::size_t i) {
    const double by_kappa = slope.log_kappa[i] + weight * rough.gradient.log_kappa[i];
    const double by_mu = slope.log_mu[i] + weight * rough.gradient.log_mu[i];
    error += std::pow(gradient[k] - by_kappa, 2) + std::pow(gradient[own + k] - by_mu, 2);
    norm += by_kappa * by_kappa + by_mu * by_mu;
  });
  EXPECT_LT(std::sqrt(pieces->sum(error) / pieces->sum(norm)), 1e-6);
}

TEST_F(PieceFits, MinimumIsThatOfTheWholeBlock) {
  Progress quiet;
  const ChannelFit expected = fit_channel(whole, 0, options, {}, quiet, {}, {});
  const PieceFit found = fit_pieces(pieces, problem, options,
                                    {[](const PathState&) {}, [] { return std::nullopt; }}, quiet);
  EXPECT_EQ(found.report.status, FitStatus::converged);
  EXPECT_NEAR(found.report.homogeneous_kappa, expected.report.homogeneous_kappa, 1e-9);
  // One objective of both, which the test above holds against the whole block's.
  PieceObjective objective(
      pieces, problem, options.solver.backend,
      {std::log(found.report.homogeneous_kappa), std::log(found.report.homogeneous_mu),
       options.regulariser.anchor_length * pieces->whole().thickness_mm()});
  objective.set_weight(*options.path.weight);
  const std::size_t own = pieces->owned().cells();
  std::vector<double> at_found(2 * own), at_expected(2 * own);
  for_own([&](std::size_t i, std::size_t k, std::size_t of_whole) {
    at_found[k] = found.fields.log_kappa[i];
    at_found[own + k] = found.fields.log_mu[i];
    at_expected[k] = std::log(expected.medium.kappa[of_whole]);
    at_expected[own + k] = std::log(expected.medium.mu[of_whole]);
  });
  const double lowest = objective.value(at_found), other = objective.value(at_expected);
  EXPECT_LT(lowest, other * (1.0 + 1e-6));
  // One machine stops where two steps in a row lower it little, here 0.2 % above.
  EXPECT_GT(lowest, other * (1.0 - 5e-3));
  double worst_kappa = 0.0, worst_mu = 0.0, structure = 0.0;
  for_own([&](std::size_t i, std::size_t, std::size_t of_whole) {
    const double log_kappa = std::log(expected.medium.kappa[of_whole]);
    worst_kappa = std::max(worst_kappa, std::abs(found.fields.log_kappa[i] - log_kappa));
    worst_mu = std::max(worst_mu,
                        std::abs(found.fields.log_mu[i] - std::log(expected.medium.mu[of_whole])));
    structure =
        std::max(structure, std::abs(log_kappa - std::log(expected.report.homogeneous_kappa)));
  });
  EXPECT_LT(worst_kappa, 2e-2);
  EXPECT_LT(worst_mu, 5e-2);
  // There was something to find.
  MPI_Allreduce(MPI_IN_PLACE, &structure, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  EXPECT_GT(structure, 0.1);
}

TEST_F(PieceFits, GoesOnFromACheckpointToTheSameBits) {
  Progress quiet;
  FitOptions path = options;
  path.path.weight.reset();
  path.path.first_weight = 3e5;
  path.path.target_chi2 = 2.0;
  path.path.final_tolerance = 1e-4;
  std::vector<PathState> states;
  const PathCheckpoint keep{[&](const PathState& s) { states.push_back(s); },
                            [] { return std::nullopt; }};
  const PieceFit whole_run = fit_pieces(pieces, problem, path, keep, quiet);
  ASSERT_GE(states.size(), 2U);
  const PieceFit resumed = fit_pieces(pieces, problem, path,
                                      {[](const PathState&) {}, [&] { return states[1]; }}, quiet);
  EXPECT_TRUE(resumed.report.resumed);
  EXPECT_TRUE(whole_run.fields == resumed.fields);
  EXPECT_EQ(whole_run.report.history.size(), resumed.report.history.size());
}

}  // namespace
}  // namespace kappamu::inverse::distributed
