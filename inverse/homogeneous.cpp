#include "inverse/homogeneous.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.h"

namespace kappamu::inverse {

namespace {

/// Spread of log data that a homogeneous block cannot follow: keeps bright, precise pixels from
/// outvoting the rest.
constexpr double heterogeneity = 0.3;
/// Vanishing predictions count as this share of the datum.
constexpr double darkest_ratio = 1e-6;
constexpr int max_iterations = 25;
/// Expected share of collisions that absorb, 3κμ, and the spread of its logarithm: marble, milk,
/// wax, skin and juices lie within two spreads (Jensen et al. 2001, table 1).
constexpr double expected_absorption = 3e-3;
constexpr double absorption_spread = 2.0;
/// Best guesses of the table from which a descent starts.
constexpr std::size_t starts = 3;
constexpr double step_tolerance = 1e-3;

struct Residuals {
  Eigen::VectorXd value;  ///< weighted
  double square = std::numeric_limits<double>::infinity();
};

class LogResidual {
 public:
  explicit LogResidual(Objective& objective) : objective_(objective) {
    const Problem& problem = objective.problem();
    for (std::size_t i = 0; i < problem.data.size(); ++i) {
      const double d = problem.data[i];
      const double w = problem.weight[i];
      if (w <= 0.0 || d * std::sqrt(w) <= 3.0) continue;
      used_.push_back(i);
      root_weight_.push_back(1.0 / std::sqrt(1.0 / (w * d * d) + heterogeneity * heterogeneity));
    }
    if (used_.empty()) {
      throw InputError(
          "no datum stands three standard deviations above zero: the channel is dark; check "
          "exposure "
          "and variance, or fit the others with --channel");
    }
  }

  Residuals operator()(const Eigen::Vector2d& p) {
    ++evaluations;
    const Problem& problem = objective_.problem();
    const std::size_t cells = problem.setup.shape.cells();
    Residuals r;
    const double misfit =
        objective_.value({std::vector<double>(cells, p[0]), std::vector<double>(cells, p[1])});
    if (!std::isfinite(misfit)) return r;
    const std::vector<double> prediction = objective_.prediction();
    r.value.resize(static_cast<Eigen::Index>(used_.size()));
    for (std::size_t k = 0; k < used_.size(); ++k) {
      const double d = problem.data[used_[k]];
      const double ratio = std::max(prediction[used_[k]] / d, darkest_ratio);
      r.value[static_cast<Eigen::Index>(k)] = root_weight_[k] * std::log(ratio);
    }
    r.square = r.value.squaredNorm();
    return r;
  }

  double root_mean_square(double square) const {
    double sum = 0.0;
    for (const double w : root_weight_) sum += w * w;
    return std::sqrt(square / sum);
  }

  /// What one pattern contributes on average to `square`.
  double per_pattern(double square) const { return square / objective_.problem().patterns; }

  int evaluations = 0;

 private:
  Objective& objective_;
  std::vector<std::size_t> used_;
  std::vector<double> root_weight_;
};

/// The weak opinion on absorption that decides where the data have none: (log 3κμ − log
/// expected)²/spread², times `weight`.
struct AbsorptionPrior {
  double weight = 0.0;

  double root() const { return std::sqrt(weight) / absorption_spread; }
  double residual(const Eigen::Vector2d& p) const {
    return root() * (p[0] + p[1] + std::log(3.0 / expected_absorption));
  }
};

struct Point {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();  ///< log κ, log μ
  Residuals at;
  bool converged = false;
};

double cost(const Point& point, const AbsorptionPrior& prior) {
  return point.at.square + std::pow(prior.residual(point.p), 2);
}

/// Levenberg-Marquardt from `point`.
Point descend(LogResidual& residual, const AbsorptionPrior& prior, Point point) {
  double damping = 1e-2;
  point.converged = false;
  for (int iteration = 0; iteration < max_iterations && !point.converged; ++iteration) {
    constexpr double difference = 1e-2;
    Eigen::MatrixXd jacobian(point.at.value.size(), 2);
    for (int k = 0; k < 2; ++k) {
      Eigen::Vector2d moved = point.p;
      moved[k] += difference;
      const Residuals r = residual(moved);
      if (r.value.size() != point.at.value.size()) return point;  // the solver's range ends here
      jacobian.col(k) = (r.value - point.at.value) / difference;
    }
    const Eigen::Vector2d along = Eigen::Vector2d::Constant(prior.root());
    const Eigen::Matrix2d normal = jacobian.transpose() * jacobian + along * along.transpose();
    const Eigen::Vector2d slope =
        jacobian.transpose() * point.at.value + along * prior.residual(point.p);
    bool lower = false;
    for (int attempt = 0; attempt < 8 && !lower; ++attempt) {
      Eigen::Matrix2d damped = normal;
      damped.diagonal() +=
          damping * normal.diagonal() + Eigen::Vector2d::Constant(1e-9 * normal.trace());
      Eigen::Vector2d step = -damped.ldlt().solve(slope);
      step = step.cwiseMax(-1.5).cwiseMin(1.5);
      point.converged = step.cwiseAbs().maxCoeff() < step_tolerance;
      if (point.converged) break;
      Point next{point.p + step, residual(point.p + step), false};
      lower = cost(next, prior) < cost(point, prior);
      if (lower) {
        point = std::move(next);
        damping = std::max(1e-6, 0.2 * damping);
      } else {
        damping *= 8.0;
      }
    }
    if (!lower) break;
  }
  return point;
}

/// The best of a table that spans marble to milk to wax at any size of block, best first, and last
/// `own`, where the solver gets along with it.
std::vector<Point> best_guesses(LogResidual& residual, double thickness,
                                const std::optional<HomogeneousGuess>& own) {
  std::vector<Point> guesses;
  const auto at = [&](double kappa, double mu) {
    const Eigen::Vector2d p(std::log(kappa), std::log(mu));
    return Point{p, residual(p), false};
  };
  for (const double kappa : {0.005, 0.02, 0.08, 0.3}) {
    for (const double attenuation : {0.1, 0.5, 2.0, 6.0}) {
      // The second guess is the thickness in diffusion lengths, √(μ/κ) ℓ.
      const double mu = attenuation * attenuation * kappa;
      if (3.0 * kappa * mu >= 0.5) continue;  // hardly scatters: no diffusion
      Point guess = at(kappa * thickness, mu / thickness);
      if (std::isfinite(guess.at.square)) guesses.push_back(std::move(guess));
    }
  }
  std::stable_sort(guesses.begin(), guesses.end(),
                   [](const Point& a, const Point& b) { return a.at.square < b.at.square; });
  guesses.resize(std::min(guesses.size(), starts));
  if (own) {
    Point guess = at(own->kappa, own->mu);
    if (std::isfinite(guess.at.square)) guesses.push_back(std::move(guess));
  }
  if (guesses.empty()) {
    throw InputError("the diffusion solver converges for none of the homogeneous starting guesses");
  }
  return guesses;
}

}  // namespace

HomogeneousFit fit_homogeneous(Objective& objective, const std::optional<HomogeneousGuess>& guess) {
  LogResidual residual(objective);
  const forward::GridSetup& setup = objective.problem().setup;
  const double thickness = setup.shape.extent(axis_of(setup.lit_face)) * setup.shape.voxel_mm;

  std::vector<Point> guesses = best_guesses(residual, thickness, guess);
  // The residuals that remain are the block's structure, common to the pixels of a pattern: the
  // prior weighs what one pattern's residuals do. First as they are at the best guess, then as the
  // descent leaves them: of exactly homogeneous data nothing is left, and the prior vanishes.
  AbsorptionPrior prior{residual.per_pattern(guesses.front().at.square)};
  std::optional<Point> best;
  for (Point& start : guesses) {
    Point found = descend(residual, prior, std::move(start));
    if (!best || cost(found, prior) < cost(*best, prior)) best = std::move(found);
  }
  prior.weight = residual.per_pattern(best->at.square);
  const Point end = descend(residual, prior, std::move(*best));

  HomogeneousFit fit;
  fit.kappa = std::exp(end.p[0]);
  fit.mu = std::exp(end.p[1]);
  fit.log_residual = residual.root_mean_square(end.at.square);
  fit.evaluations = residual.evaluations;
  fit.converged = end.converged;
  return fit;
}

}  // namespace kappamu::inverse
