#include "inverse/block_model/homogeneous.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/error.h"
#include "forward/analytic/homogeneous_block.h"
#include "inverse/defaults.h"
#include "inverse/optimise/levenberg_marquardt.h"
#include "inverse/problem/lit_face.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::homogeneous;

/// Predictions r M at the data used; empty if the solver fails.
using Predict = std::function<std::vector<double>(const Eigen::VectorXd& logs)>;

bool above_noise(const Problem& problem, std::size_t i) {
  return problem.weight[i] > 0.0 &&
         problem.data[i] * std::sqrt(problem.weight[i]) > above_noise_deviations;
}

class LogResidual final : public Residuals {
 public:
  LogResidual(const Problem& problem, const std::vector<std::size_t>& used, Predict predict)
      : patterns_(problem.patterns), predict_(std::move(predict)) {
    for (const std::size_t i : used) {
      const double d = problem.data[i];
      datum_.push_back(d);
      root_weight_.push_back(
          1.0 / std::sqrt(1.0 / (problem.weight[i] * d * d) + heterogeneity * heterogeneity));
    }
  }

  Eigen::VectorXd residual(const Eigen::VectorXd& p) override {
    if (p.cwiseAbs().maxCoeff() > max_log_coefficient) return {};
    const std::vector<double> prediction = predict_(p);
    Eigen::VectorXd r(static_cast<Eigen::Index>(prediction.size()));
    for (std::size_t k = 0; k < prediction.size(); ++k) {
      const double ratio = std::max(prediction[k] / datum_[k], defaults::expected::darkest_ratio);
      r[static_cast<Eigen::Index>(k)] = root_weight_[k] * std::log(ratio);
    }
    return r;
  }

  /// By log κ and log μ, from differences.
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& p) override {
    const Eigen::VectorXd here = residual(p);
    Eigen::MatrixXd result(here.size(), 2);
    for (int unknown = 0; unknown < 2; ++unknown) {
      const Eigen::VectorXd there = residual(p + difference * Eigen::Vector2d::Unit(unknown));
      if (here.size() == 0 || there.size() == 0) return {};
      result.col(unknown) = (there - here) / difference;
    }
    return result;
  }

  double root_mean_square(double square) const {
    double sum = 0.0;
    for (const double w : root_weight_) sum += w * w;
    return std::sqrt(square / sum);
  }

  /// Mean contribution of one pattern to `square`.
  double per_pattern(double square) const { return square / patterns_; }

 private:
  int patterns_;
  Predict predict_;
  std::vector<double> datum_;
  std::vector<double> root_weight_;
};

/// The weak opinion on absorption that decides where the data have none: (log 3κμ − log
/// expected)²/spread², times `weight`.
LinearPrior absorption_prior(double weight) {
  const double root = std::sqrt(weight) / defaults::expected::absorption_spread;
  return {Eigen::MatrixXd::Constant(1, 2, root),
          Eigen::VectorXd::Constant(1, root * std::log(defaults::expected::absorption / 3.0))};
}

double square(const LeastSquaresState& at) {
  return at.residual.size() > 0 ? at.residual.squaredNorm()
                                : std::numeric_limits<double>::infinity();
}

bool descend(LogResidual& residual, const LinearPrior& prior, LeastSquaresState& at,
             double tolerance) {
  const auto next = [tolerance](const PlannedStep& planned) {
    return planned.step.cwiseAbs().maxCoeff() < tolerance ? Continue::converged : Continue::yes;
  };
  return levenberg_marquardt(residual, prior, at, {.longest_step = longest_step}, next).converged;
}

/// `count` positions of `voxels`, one by chance in each of as many equal parts: no pattern of light
/// keeps step with them.
std::vector<int> spread_positions(int voxels, int count, std::mt19937& chance) {
  std::vector<int> positions;
  for (int k = 0; k < count; ++k) {
    const int begin = k * voxels / count;
    const auto choices = static_cast<unsigned>((k + 1) * voxels / count - begin);
    positions.push_back(begin + static_cast<int>(chance() % choices));
  }
  return positions;
}

/// Pixels of all patterns, and which of their data are above noise.
struct SomeData {
  forward::FacePixels pixels;
  std::vector<std::size_t> used;  ///< of the problem's data
  std::vector<std::size_t> at;    ///< of the pixels' predictions
};
SomeData some_data(const Problem& problem) {
  const FaceShape face = problem.seen_shape();
  std::mt19937 chance(1);
  int side = std::max(least_side, static_cast<int>(std::sqrt(enough_pixels / problem.patterns)));
  for (;; side *= 2) {
    SomeData some;
    some.pixels = {spread_positions(face.nu, std::min(side, face.nu), chance),
                   spread_positions(face.nv, std::min(side, face.nv), chance)};
    std::size_t at = 0;
    for (int m = 0; m < problem.patterns; ++m) {
      for (const int v : some.pixels.v) {
        for (const int u : some.pixels.u) {
          const std::size_t i = (static_cast<std::size_t>(m) * face.nv + v) * face.nu + u;
          if (above_noise(problem, i)) {
            some.used.push_back(i);
            some.at.push_back(at);
          }
          ++at;
        }
      }
    }
    if (some.used.size() >= least_used || side >= std::max(face.nu, face.nv)) return some;
  }
}

/// [L][face][pixel] of [face][L][pixel].
std::vector<double> interleaved(const std::vector<std::vector<double>>& of_faces,
                                std::size_t pixels) {
  if (of_faces.size() == 1) return of_faces.front();
  std::vector<double> all;
  for (std::size_t first = 0; first < of_faces.front().size(); first += pixels) {
    for (const std::vector<double>& face : of_faces) {
      const auto begin = face.begin() + static_cast<std::ptrdiff_t>(first);
      all.insert(all.end(), begin, begin + static_cast<std::ptrdiff_t>(pixels));
    }
  }
  return all;
}

/// The lowest places of a table that no neighbour is below, lowest first.
std::vector<LeastSquaresState> lowest_places(LogResidual& residual, double thickness) {
  const auto between = [](double first, double last, int k, int count) {
    return std::log(first) + std::log(last / first) * k / (count - 1);
  };
  std::vector<LeastSquaresState> table;
  for (int row = 0; row < rows; ++row) {
    const double log_kappa = std::log(thickness) + between(first_kappa, last_kappa, row, rows);
    for (int column = 0; column < columns; ++column) {
      const double log_share = between(first_share, last_share, column, columns);
      const Eigen::Vector2d p(log_kappa, log_share - std::log(3.0) - log_kappa);
      table.push_back({p, residual.residual(p), {}});
    }
  }
  const auto cost = [&](int row, int column) {
    return square(table[static_cast<std::size_t>(row) * columns + column]);
  };
  std::vector<LeastSquaresState> lowest;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      bool low = true;
      for (int r = std::max(0, row - 1); r <= std::min(rows - 1, row + 1); ++r) {
        for (int c = std::max(0, column - 1); c <= std::min(columns - 1, column + 1); ++c) {
          low = low && cost(row, column) <= cost(r, c);
        }
      }
      if (low) lowest.push_back(table[static_cast<std::size_t>(row) * columns + column]);
    }
  }
  std::sort(lowest.begin(), lowest.end(),
            [](const auto& a, const auto& b) { return square(a) < square(b); });
  if (lowest.size() > most_descents) lowest.resize(most_descents);
  return lowest;
}

/// The end of a descent from `best`. The residuals that remain are the block's structure, common to
/// the pixels of a pattern: the prior weighs what one pattern's residuals do, as the last descent
/// left them; of exactly homogeneous data nothing is left, and the prior vanishes.
HomogeneousFit settle(LogResidual& residual, LeastSquaresState at) {
  const LinearPrior prior = absorption_prior(residual.per_pattern(square(at)));
  HomogeneousFit fit;
  fit.converged = descend(residual, prior, at, step_tolerance);
  fit.kappa = std::exp(at.p[0]);
  fit.mu = std::exp(at.p[1]);
  fit.log_residual = residual.root_mean_square(square(at));
  if (at.jacobian.rows() > 0) {
    const Eigen::Matrix2d precision =
        at.jacobian.transpose() * at.jacobian + prior.rows.transpose() * prior.rows;
    fit.deviation = (residual.per_pattern(square(at)) * precision.inverse()).diagonal().cwiseSqrt();
  }
  fit.jacobian = std::move(at.jacobian);
  return fit;
}

/// What a homogeneous block lets through at `some` data of a problem; of both by reference.
class BlockAtData {
 public:
  BlockAtData(const Problem& problem, const SomeData& some)
      : some_(some),
        views_(problem.views()),
        light_(views_.of_lights(problem.irradiance)),
        lateral_(!problem.lateral.empty()),
        lit_(problem) {
    for (const Face face : views_.faces().list) {
      blocks_.emplace_back(problem.setup, face, light_, some.pixels);
    }
  }

  std::vector<double> operator()(double kappa, double mu) {
    std::vector<std::vector<double>> exitance;
    for (forward::HomogeneousBlock& block : blocks_) exitance.push_back(block.exitance(kappa, mu));
    const std::vector<double> all =
        views_.pictures(interleaved(exitance, some_.pixels.u.size() * some_.pixels.v.size()));
    std::vector<double> prediction;
    for (const std::size_t at : some_.at) prediction.push_back(all[at]);
    if (!lateral_) return prediction;
    const std::vector<double> where_lit = lit_.exitance(kappa, mu);
    for (std::size_t k = 0; k < prediction.size(); ++k) {
      if (where_lit[some_.used[k]] > 0.0) prediction[k] = where_lit[some_.used[k]];
    }
    return prediction;
  }

 private:
  const SomeData& some_;
  Views views_;
  std::vector<double> light_;
  bool lateral_;
  LitFace lit_;
  std::vector<forward::HomogeneousBlock> blocks_;  ///< one for each face that is seen
};

}  // namespace

HomogeneousFit find_homogeneous(const Problem& problem,
                                const std::optional<HomogeneousGuess>& guess) {
  const SomeData some = some_data(problem);
  if (some.used.empty()) {
    throw InputError(
        "no datum stands three standard deviations above zero: the channel is dark; check exposure "
        "and variance, or fit the other channels alone",
        {{"channels"}});
  }
  BlockAtData block(problem, some);
  LogResidual residual(problem, some.used, [&](const Eigen::VectorXd& p) {
    return block(std::exp(p[0]), std::exp(p[1]));
  });
  const FaceShape face = problem.lit_shape();
  if (problem.lateral.empty() && std::min(face.nu, face.nv) >= many_voxels) {
    const Eigen::Vector2d p = find_homogeneous(coarsen(problem, ModelError{}), guess).logs();
    return settle(residual, {p, residual.residual(p), {}});
  }
  std::vector<LeastSquaresState> places = lowest_places(residual, problem.setup.thickness_mm());
  if (guess) {
    const Eigen::Vector2d p(std::log(guess->kappa), std::log(guess->mu));
    if (Eigen::VectorXd r = residual.residual(p); r.size() > 0) places.push_back({p, r, {}});
  }
  const auto least = [&](const auto& cost) {
    return *std::min_element(places.begin(), places.end(),
                             [&](const auto& a, const auto& b) { return cost(a) < cost(b); });
  };
  const auto prior = [&] { return absorption_prior(residual.per_pattern(square(least(square)))); };
  // The prior weighs what the best place leaves, which descents lower.
  for (int round = 0; round < prior_rounds; ++round) {
    const LinearPrior now = prior();
    for (LeastSquaresState& place : places) descend(residual, now, place, interim_tolerance);
  }
  const LinearPrior last = prior();
  return settle(residual,
                least([&](const LeastSquaresState& at) { return square(at) + last.square(at.p); }));
}

HomogeneousFit refit_homogeneous(Objective& objective, const HomogeneousFit& from) {
  const Problem& problem = objective.problem();
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    if (above_noise(problem, i)) used.push_back(i);
  }
  LogResidual residual(problem, used, [&](const Eigen::VectorXd& p) {
    const std::size_t cells = problem.setup.shape.cells();
    std::vector<double> prediction;
    const double value =
        objective.value({std::vector<double>(cells, p[0]), std::vector<double>(cells, p[1])});
    if (!std::isfinite(value)) return prediction;
    const std::vector<double> all = objective.prediction();
    for (const std::size_t i : used) prediction.push_back(all[i]);
    return prediction;
  });
  const Eigen::VectorXd p = from.logs();
  return settle(residual, {p, residual.residual(p), from.jacobian});
}

}  // namespace kappamu::inverse
