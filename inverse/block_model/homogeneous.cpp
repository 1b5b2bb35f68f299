#include "inverse/block_model/homogeneous.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.h"
#include "inverse/problem/expected_blocks.h"

namespace kappamu::inverse {

namespace {

/// Spread of log data that a homogeneous block cannot follow: keeps bright, precise pixels from
/// outvoting the rest.
constexpr double heterogeneity = 0.3;
constexpr int max_iterations = 25;
/// Largest last step [log units] of what leads to the end, and there.
constexpr double interim_tolerance = 2e-2;
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
    const Problem& problem = objective_.problem();
    Residuals r;
    if (!std::isfinite(objective_.value(even(p)))) return r;
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

  /// By log κ and log μ at p; empty where the solver fails. Two tangent solves, and one more where
  /// p is not what was evaluated last.
  Eigen::MatrixXd jacobian(const Eigen::Vector2d& p) {
    const Problem& problem = objective_.problem();
    if (!std::isfinite(objective_.value(even(p)))) return {};
    const std::vector<double> prediction = objective_.prediction();
    Eigen::MatrixXd result(static_cast<Eigen::Index>(used_.size()), 2);
    for (int unknown = 0; unknown < 2; ++unknown) {
      const std::vector<double> change = objective_.jacobian(even(Eigen::Vector2d::Unit(unknown)));
      for (std::size_t k = 0; k < used_.size(); ++k) {
        const std::size_t i = used_[k];
        const bool seen = prediction[i] > darkest_ratio * problem.data[i];
        result(static_cast<Eigen::Index>(k), unknown) =
            seen ? root_weight_[k] * change[i] / (std::sqrt(problem.weight[i]) * prediction[i])
                 : 0.0;
      }
    }
    return result;
  }

  double root_mean_square(double square) const {
    double sum = 0.0;
    for (const double w : root_weight_) sum += w * w;
    return std::sqrt(square / sum);
  }

  /// What one pattern contributes on average to `square`.
  double per_pattern(double square) const { return square / objective_.problem().patterns; }

 private:
  /// Fields that are p everywhere.
  CoefficientPair even(const Eigen::Vector2d& p) const {
    const std::size_t cells = objective_.problem().setup.shape.cells();
    return {std::vector<double>(cells, p[0]), std::vector<double>(cells, p[1])};
  }

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
  Eigen::MatrixXd jacobian;  ///< [used][2] of the residuals; empty before it is known
  bool converged = false;
};

double cost(const Point& point, const AbsorptionPrior& prior) {
  return point.at.square + std::pow(prior.residual(point.p), 2);
}

/// Levenberg-Marquardt from `point`, which keeps its Jacobian: Broyden's update makes it good for
/// the next step, and a fresh one costs two solves only where a step disappoints.
Point descend(LogResidual& residual, const AbsorptionPrior& prior, Point point, double tolerance) {
  double damping = 1e-2;
  point.converged = false;
  bool fresh = false;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    if (point.jacobian.size() == 0) {
      point.jacobian = residual.jacobian(point.p);
      fresh = true;
      if (point.jacobian.size() == 0) return point;  // the solver's range ends here
    }
    const Eigen::Vector2d along = Eigen::Vector2d::Constant(prior.root());
    const Eigen::Matrix2d normal =
        point.jacobian.transpose() * point.jacobian + along * along.transpose();
    const Eigen::Vector2d slope =
        point.jacobian.transpose() * point.at.value + along * prior.residual(point.p);
    Eigen::Matrix2d damped = normal;
    damped.diagonal() +=
        damping * normal.diagonal() + Eigen::Vector2d::Constant(1e-9 * normal.trace());
    const Eigen::Vector2d step = (-damped.ldlt().solve(slope)).cwiseMax(-1.5).cwiseMin(1.5);
    point.converged = step.cwiseAbs().maxCoeff() < tolerance;
    if (point.converged) return point;
    Point next{point.p + step, residual(point.p + step), {}, false};
    const double promised = -(2.0 * slope.dot(step) + step.dot(normal * step));
    const double gain = cost(point, prior) - cost(next, prior);
    const bool poor = gain < trusted_step * promised;
    if (gain > 0.0) {
      const Eigen::VectorXd surprise = next.at.value - point.at.value - point.jacobian * step;
      next.jacobian = std::move(point.jacobian);
      next.jacobian += surprise / step.squaredNorm() * step.transpose();
      point = std::move(next);
      damping = std::max(1e-6, 0.2 * damping);
    } else {
      damping *= 8.0;
    }
    if (poor && (gain > 0.0 || !fresh)) point.jacobian.resize(0, 0);
    fresh = fresh && gain <= 0.0;
  }
  return point;
}

/// The best of a table that spans marble to milk to wax at any size of block, first along κ, then
/// along the attenuation; and `own`, where the solver gets along with it.
std::vector<Point> best_guesses(LogResidual& residual, double thickness,
                                const std::optional<HomogeneousGuess>& own) {
  const auto at = [&](double kappa, double mu) {
    const Eigen::Vector2d p(std::log(kappa), std::log(mu));
    return Point{p, residual(p), {}, false};
  };
  // Attenuation is the thickness in diffusion lengths, √(μ/κ) ℓ.
  const auto of_slab = [&](double kappa, double attenuation) {
    return at(kappa * thickness, attenuation * attenuation * kappa / thickness);
  };
  const auto better = [](Point a, Point b) { return b.at.square < a.at.square ? b : a; };
  std::array<Point, 2> usual{of_slab(0.02, 1.0), of_slab(0.1, 1.0)};
  const double kappa = usual[1].at.square < usual[0].at.square ? 0.1 : 0.02;
  std::vector<Point> guesses;
  const auto offer = [&](Point guess) {
    if (std::isfinite(guess.at.square)) guesses.push_back(std::move(guess));
  };
  offer(better(better(better(usual[0], usual[1]), of_slab(kappa, 0.3)), of_slab(kappa, 3.0)));
  if (own) offer(at(own->kappa, own->mu));
  if (guesses.empty()) {
    throw InputError("the diffusion solver converges for none of the homogeneous starting guesses");
  }
  return guesses;
}

/// The end of a descent from `best`. The residuals that remain are the block's structure, common to
/// the pixels of a pattern: the prior weighs what one pattern's residuals do, as the last descent
/// left them; of exactly homogeneous data nothing is left, and the prior vanishes.
HomogeneousFit settle(LogResidual& residual, Point best) {
  const AbsorptionPrior prior{residual.per_pattern(best.at.square)};
  const Point end = descend(residual, prior, std::move(best), step_tolerance);
  HomogeneousFit fit;
  fit.kappa = std::exp(end.p[0]);
  fit.mu = std::exp(end.p[1]);
  fit.log_residual = residual.root_mean_square(end.at.square);
  fit.converged = end.converged;
  fit.jacobian = end.jacobian;
  return fit;
}

}  // namespace

HomogeneousFit fit_homogeneous(Objective& objective, const std::optional<HomogeneousGuess>& guess) {
  LogResidual residual(objective);
  const forward::GridSetup& setup = objective.problem().setup;
  const double thickness = setup.shape.extent(axis_of(setup.lit_face)) * setup.shape.voxel_mm;
  std::vector<Point> guesses = best_guesses(residual, thickness, guess);
  const AbsorptionPrior prior{residual.per_pattern(guesses.front().at.square)};
  std::optional<Point> best;
  for (Point& start : guesses) {
    Point found = descend(residual, prior, std::move(start), interim_tolerance);
    if (!best || cost(found, prior) < cost(*best, prior)) best = std::move(found);
  }
  return settle(residual, std::move(*best));
}

HomogeneousFit refit_homogeneous(Objective& objective, const HomogeneousFit& from) {
  LogResidual residual(objective);
  const Eigen::Vector2d p(std::log(from.kappa), std::log(from.mu));
  return settle(residual, {p, residual(p), from.jacobian, false});
}

}  // namespace kappamu::inverse
