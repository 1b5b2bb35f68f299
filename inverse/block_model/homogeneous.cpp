#include "inverse/block_model/homogeneous.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.h"
#include "inverse/optimise/levenberg_marquardt.h"
#include "inverse/problem/expected_blocks.h"

namespace kappamu::inverse {

namespace {

/// Spread of log data that a homogeneous block cannot follow: keeps bright, precise pixels from
/// outvoting the rest.
constexpr double heterogeneity = 0.3;
/// Largest last step [log units] of what leads to the end, and there.
constexpr double interim_tolerance = 2e-2;
constexpr double step_tolerance = 1e-3;

class LogResidual final : public Residuals {
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

  Eigen::VectorXd residual(const Eigen::VectorXd& p) override {
    const Problem& problem = objective_.problem();
    if (!std::isfinite(objective_.value(even(p)))) return {};
    const std::vector<double> prediction = objective_.prediction();
    Eigen::VectorXd r(static_cast<Eigen::Index>(used_.size()));
    for (std::size_t k = 0; k < used_.size(); ++k) {
      const double d = problem.data[used_[k]];
      const double ratio = std::max(prediction[used_[k]] / d, darkest_ratio);
      r[static_cast<Eigen::Index>(k)] = root_weight_[k] * std::log(ratio);
    }
    return r;
  }

  /// By log κ and log μ. Two tangent solves, and one more where p is not what was evaluated last.
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& p) override {
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
  CoefficientPair even(const Eigen::VectorXd& p) const {
    const std::size_t cells = objective_.problem().setup.shape.cells();
    return {std::vector<double>(cells, p[0]), std::vector<double>(cells, p[1])};
  }

  Objective& objective_;
  std::vector<std::size_t> used_;
  std::vector<double> root_weight_;
};

/// The weak opinion on absorption that decides where the data have none: (log 3κμ − log
/// expected)²/spread², times `weight`.
LinearPrior absorption_prior(double weight) {
  const double root = std::sqrt(weight) / absorption_spread;
  return {Eigen::MatrixXd::Constant(1, 2, root),
          Eigen::VectorXd::Constant(1, root * std::log(expected_absorption / 3.0))};
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
  return levenberg_marquardt(residual, prior, at, {.longest_step = 1.5}, next).converged;
}

/// The best of a table that spans marble to milk to wax at any size of block, first along κ, then
/// along the attenuation; and `own`, where the solver gets along with it.
std::vector<LeastSquaresState> best_guesses(LogResidual& residual, double thickness,
                                            const std::optional<HomogeneousGuess>& own) {
  const auto at = [&](double kappa, double mu) {
    const Eigen::Vector2d p(std::log(kappa), std::log(mu));
    return LeastSquaresState{p, residual.residual(p), {}};
  };
  // Attenuation is the thickness in diffusion lengths, √(μ/κ) ℓ.
  const auto of_slab = [&](double kappa, double attenuation) {
    return at(kappa * thickness, attenuation * attenuation * kappa / thickness);
  };
  const auto better = [](LeastSquaresState a, LeastSquaresState b) {
    return square(b) < square(a) ? b : a;
  };
  std::array<LeastSquaresState, 2> usual{of_slab(0.02, 1.0), of_slab(0.1, 1.0)};
  const double kappa = square(usual[1]) < square(usual[0]) ? 0.1 : 0.02;
  std::vector<LeastSquaresState> guesses;
  const auto offer = [&](LeastSquaresState guess) {
    if (std::isfinite(square(guess))) guesses.push_back(std::move(guess));
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

}  // namespace

HomogeneousFit fit_homogeneous(Objective& objective, const std::optional<HomogeneousGuess>& guess) {
  LogResidual residual(objective);
  const forward::GridSetup& setup = objective.problem().setup;
  const double thickness = setup.thickness_mm();
  std::vector<LeastSquaresState> guesses = best_guesses(residual, thickness, guess);
  const LinearPrior prior = absorption_prior(residual.per_pattern(square(guesses.front())));
  for (LeastSquaresState& found : guesses) descend(residual, prior, found, interim_tolerance);
  const auto cost = [&](const LeastSquaresState& at) { return square(at) + prior.square(at.p); };
  return settle(residual,
                *std::min_element(guesses.begin(), guesses.end(),
                                  [&](const auto& a, const auto& b) { return cost(a) < cost(b); }));
}

HomogeneousFit refit_homogeneous(Objective& objective, const HomogeneousFit& from) {
  LogResidual residual(objective);
  const Eigen::Vector2d p = from.logs();
  return settle(residual, {p, residual.residual(p), from.jacobian});
}

}  // namespace kappamu::inverse
