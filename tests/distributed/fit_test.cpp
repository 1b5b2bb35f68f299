// What is minimised by pieces is what a whole block's fit minimises, and so is its minimum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <utility>
#include <vector>

#include "inverse/distributed/distributed_fit.h"
#include "inverse/distributed/piece_waves.h"
#include "inverse/optimise/lateral_hessian.h"
#include "inverse/problem/grid_levels.h"

namespace kappamu::inverse::distributed {
namespace {

using forward::distributed::Box;

/// A block with a core whose κ is lower by `contrast`, measured with noise of 1 %.
SurfaceMeasurements measured(double contrast, Face seen, const SmoothError& shared) {
  SurfaceMeasurements m;
  m.seen_face = seen;
  m.smooth_error = shared;
  m.grid = {12, 10, 8, 0.5};
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
        kappa[m.grid.index(x, y, z)] /= contrast;
        mu[m.grid.index(x, y, z)] = 0.03;
      }
    }
  }
  op->set_medium(kappa, mu);
  const std::vector<double> light(m.irradiance.begin(), m.irradiance.end());
  for (const double value : solve_exitance(*op, light, m.patterns, {8, {1e-10, 500}})) {
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
  options.path.model = Model::volume;
  options.path.weight = weight;
  options.path.stage_tolerance = options.path.final_tolerance = 1e-9;
  options.uncertainty.probes = 0;
  options.solver.backend.device = "reference";
  options.solver.backend.precision = forward::Precision::double_precision;
  options.solver.backend.solve = {1e-9, 500};
  return options;
}

/// A block's measurements, whole and in pieces.
struct PieceCase {
  explicit PieceCase(double contrast = 2.5, Face seen = Face::z_plus,
                     const SmoothError& shared = {})
      : whole(measured(contrast, seen, shared)) {}

  const SurfaceMeasurements whole;
  const std::shared_ptr<const BlockPieces> pieces =
      std::make_shared<BlockPieces>(PETSC_COMM_WORLD, make_setup(whole, {}), 3);
  const FitOptions options = by_weight(3000.0);
  const PieceGrid data{
      pieces, piece_problem(*pieces, of_piece(*pieces, whole), {}, options.data.model_error)};

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

  CoefficientPair own_of(const CoefficientPair& all) const {
    const std::size_t count = pieces->owned().cells();
    CoefficientPair own{std::vector<double>(count), std::vector<double>(count)};
    for_own([&](std::size_t, std::size_t k, std::size_t i) {
      own.log_kappa[k] = all.log_kappa[i];
      own.log_mu[k] = all.log_mu[i];
    });
    return own;
  }
};

class PieceFits : public testing::Test, protected PieceCase {};

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
  Backend exact = options.solver.backend;
  exact.refined_tolerance = 1e-9;
  for (const RegulariserKind kind : {RegulariserKind::h1, RegulariserKind::huber_tv}) {
    for (const bool corrected : {false, true}) {
      const Regulariser regulariser{kind, 1.0};
      const DataTermOptions term{kind == RegulariserKind::h1 ? Loss::gaussian : Loss::student};
      Objective objective(make_problem(whole, 0, {}, options.data.model_error), exact, term);
      objective.set_derivative_tolerance(1e-9);
      if (corrected) objective.refresh_correction(refine(objective.problem()), fields);
      const Roughness rough = roughness(objective.space(), fields, anchor, regulariser);
      const double expected = objective.value(fields) + weight * rough.value;
      const CoefficientPair slope = objective.gradient();

      PieceObjective by_pieces(data,
                               corrected ? piece_refinement(data, nullptr) : PieceRefinement{},
                               exact, term, anchor, regulariser);
      by_pieces.set_derivative_tolerance(1e-9);
      by_pieces.set_weight(weight);
      const CoefficientPair own = own_of(fields);
      if (corrected) by_pieces.renew_correction(own);
      EXPECT_NEAR(by_pieces.value(own), expected, 1e-6 * expected);
      EXPECT_NEAR(by_pieces.chi2_per_value(), objective.chi2_per_value(),
                  4e-6 * objective.chi2_per_value());
      const CoefficientPair gradient = by_pieces.gradient();
      double error = 0.0, norm = 0.0;
      for_own([&](std::size_t, std::size_t k, std::size_t i) {
        const double by_kappa = slope.log_kappa[i] + weight * rough.gradient.log_kappa[i];
        const double by_mu = slope.log_mu[i] + weight * rough.gradient.log_mu[i];
        error +=
            std::pow(gradient.log_kappa[k] - by_kappa, 2) + std::pow(gradient.log_mu[k] - by_mu, 2);
        norm += by_kappa * by_kappa + by_mu * by_mu;
      });
      EXPECT_LT(std::sqrt(pieces->sum(error) / pieces->sum(norm)), 1e-6)
          << "corrected " << corrected;
    }
  }
}

TEST_F(PieceFits, WavesAndMetricAreThoseOfTheWholeBlock) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  std::vector<CoefficientPair> rows(2);
  std::vector<CoefficientPair> own_rows;
  for (CoefficientPair& row : rows) {
    for (std::size_t i = 0; i < whole.grid.cells(); ++i) {
      row.log_kappa.push_back(normal(random));
      row.log_mu.push_back(normal(random));
    }
    own_rows.push_back(own_of(row));
  }
  const MediumSpace space = forward::block_space(whole.grid, whole.lit_face);
  const auto waves = std::make_shared<PieceWaves>(*pieces);
  const LateralBlocks expected = lateral_blocks(rows, space), found = waves->blocks(own_rows);
  const BasisOptions how{Coordinates::informed, 3.0, 5.0, 0.5, 0.7};
  const Basis whole_basis(space, how, expected), basis(waves, space, how, found);
  EXPECT_NEAR(pieces->sum(basis.determined(found)), whole_basis.determined(expected), 1e-8);
  const CoefficientPair back = basis.to_fields(basis.from_fields(own_rows[0]));
  const CoefficientPair by_whole = own_of(whole_basis.to_fields(whole_basis.gradient(rows[1])));
  const CoefficientPair by_parts = basis.to_fields(basis.gradient(own_rows[1]));
  for (std::size_t k = 0; k < back.log_mu.size(); ++k) {
    ASSERT_NEAR(back.log_kappa[k], own_rows[0].log_kappa[k], 1e-10);
    ASSERT_NEAR(back.log_mu[k], own_rows[0].log_mu[k], 1e-10);
    ASSERT_NEAR(by_parts.log_kappa[k], by_whole.log_kappa[k], 1e-10);
    ASSERT_NEAR(by_parts.log_mu[k], by_whole.log_mu[k], 1e-10);
  }
}

TEST_F(PieceFits, GridsAreThoseOfTheWholeBlock) {
  const ModelError coarse{0.03, 3e-3};
  const GridLevels expected(make_problem(whole, 0, {}, options.data.model_error), coarse,
                            DataWeights::by_variance, 2);
  const std::vector<PieceGrid> levels = piece_levels(data, coarse, 2);
  ASSERT_EQ(levels.size(), 2U);
  const auto& [parts, problem] = levels[1];
  EXPECT_TRUE(parts->whole().shape == expected[1].setup.shape);
  const auto weighed = [](const Problem& p) {
    double sum = 0.0;
    for (std::size_t i = 0; i < p.data.size(); ++i) sum += p.weight[i] * p.data[i] * p.data[i];
    return sum;
  };
  EXPECT_NEAR(pieces->sum(weighed(problem)), weighed(expected[1]), 1e-9 * weighed(expected[1]));
  double light = 0.0, all_light = 0.0;
  for (const double e : problem.irradiance) light += e;
  for (const double e : expected[1].irradiance) all_light += e;
  EXPECT_NEAR(pieces->sum(light), all_light, 1e-9 * all_light);

  CoefficientPair field{std::vector<double>(expected[1].setup.shape.cells()), {}};
  for (std::size_t i = 0; i < field.log_kappa.size(); ++i) field.log_kappa[i] = std::sin(0.7 * i);
  field.log_mu = field.log_kappa;
  CoefficientPair own{std::vector<double>(parts->owned().cells()), {}};
  const auto& box = parts->owned();
  std::size_t k = 0;
  for (int z = box.begin[2]; z < box.end[2]; ++z) {
    for (int y = box.begin[1]; y < box.end[1]; ++y) {
      for (int x = box.begin[0]; x < box.end[0]; ++x) {
        own.log_kappa[k++] = field.log_kappa[expected[1].setup.shape.index(x, y, z)];
      }
    }
  }
  own.log_mu = own.log_kappa;
  const CoefficientPair finer = to_finer(own, *parts, *pieces);
  const CoefficientPair of_whole = own_of(expected.to_finer(field, 1));
  for (std::size_t i = 0; i < finer.log_kappa.size(); ++i) {
    ASSERT_NEAR(finer.log_kappa[i], of_whole.log_kappa[i], 1e-12);
  }
}

/// How far two volumes are apart, log κ and log μ, the root of the mean square.
double apart(const CoefficientPair& a, const CoefficientPair& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.log_mu.size(); ++i) {
    squares +=
        std::pow(a.log_kappa[i] - b.log_kappa[i], 2) + std::pow(a.log_mu[i] - b.log_mu[i], 2);
  }
  return std::sqrt(squares / static_cast<double>(2 * a.log_mu.size()));
}

int steps_of(const FitReport& report) {
  int steps = 0;
  for (const StepRecord& record : report.history) steps += record.step > 0 ? 1 : 0;
  return steps;
}

/// With solves to 1e-6 the fit of pieces is the whole block's. Loose solves, as usual, lead either
/// as far from there as the other one.
TEST(PathsOfPieces, EndWhereTheWholeBlocksDo) {
  Progress quiet;
  const std::vector<std::pair<PieceCase, Loss>> cases{
      {PieceCase(2.5, Face::z_plus), Loss::gaussian},
      {PieceCase(1e4, Face::z_plus), Loss::gaussian},
      {PieceCase(2.5, Face::z_minus), Loss::gaussian},
      {PieceCase(2.5, Face::z_plus, {1e-3, 1e-3}), Loss::gaussian},
      {PieceCase(2.5, Face::z_plus), Loss::student}};
  for (const auto& [one, loss] : cases) {
    FitOptions exact = one.options;
    exact.data.term.loss = loss;
    exact.path.weight.reset();
    exact.path.stage_tolerance = 1e-3;
    exact.path.final_tolerance = 3e-4;
    exact.solver.backend.solve.tolerance = exact.solver.backend.refined_tolerance = 1e-6;
    exact.solver.backend.loose_solves = false;
    FitOptions loose = exact, other_probes = exact;
    loose.solver.backend.loose_solves = true;
    other_probes.solver.seed = 2;
    const auto whole = [&](const FitOptions& how) {
      return fit_channel(one.whole, 0, how, {}, quiet, {}, {});
    };
    const auto by_pieces = [&](const FitOptions& how) {
      return fit_pieces(one.data, how, {[](const PathState&) {}, [] { return std::nullopt; }},
                        quiet);
    };
    const ChannelFit expected = whole(exact), loose_whole = whole(loose);
    const PieceFit found = by_pieces(exact), loose_found = by_pieces(loose);
    EXPECT_EQ(found.report.status, expected.report.status);
    EXPECT_EQ(found.report.end, expected.report.end);
    EXPECT_NEAR(found.report.weight, expected.report.weight, 1e-9 * expected.report.weight);
    EXPECT_NEAR(found.report.chi2_per_value, expected.report.chi2_per_value, 1e-3);
    const CoefficientPair of_whole = one.own_of(to_fields(expected.medium));
    const auto distance = [&](const CoefficientPair& own) {
      const auto count = static_cast<double>(of_whole.log_mu.size());
      return std::sqrt(one.pieces->sum(count * std::pow(apart(own, of_whole), 2)) /
                       static_cast<double>(one.whole.grid.cells()));
    };
    const auto from_whole = [&](const ChannelFit& fit) {
      return apart(to_fields(fit.medium), to_fields(expected.medium));
    };
    const double by_probes = from_whole(whole(other_probes));
    // Of all ranks: each asks.
    const double by_exact = distance(found.own), by_loose = distance(loose_found.own);
    EXPECT_LT(by_exact, 0.1 * by_probes);
    EXPECT_LT(by_loose, 2.5 * std::max(from_whole(loose_whole), by_probes));
    EXPECT_NEAR(steps_of(found.report), steps_of(expected.report), 2);
    if (one.pieces->rank() == 0) {
      std::printf(
          "%d ranks: %d steps, %d solves; whole: %d steps, %d solves; apart %.2g; from there by "
          "loose solves: pieces %.2g, whole %.2g; by other probes %.2g; chi2 %.4g and %.4g\n",
          one.pieces->ranks(), steps_of(found.report), found.report.solves.total(),
          steps_of(expected.report), expected.report.solves.total(), by_exact, by_loose,
          from_whole(loose_whole), by_probes, found.report.chi2_per_value,
          expected.report.chi2_per_value);
    }
  }
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
  const PieceFit whole_run = fit_pieces(data, path, keep, quiet);
  ASSERT_GE(states.size(), 2U);
  const PieceFit resumed =
      fit_pieces(data, path, {[](const PathState&) {}, [&] { return states[1]; }}, quiet);
  EXPECT_TRUE(resumed.report.resumed);
  EXPECT_TRUE(whole_run.fields == resumed.fields);
  EXPECT_EQ(whole_run.report.history.size(), resumed.report.history.size());
}

}  // namespace
}  // namespace kappamu::inverse::distributed
