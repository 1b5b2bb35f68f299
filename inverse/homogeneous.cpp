#include "inverse/homogeneous.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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
          "no datum stands three standard deviations above zero; check exposure and variance");
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

  int evaluations = 0;

 private:
  Objective& objective_;
  std::vector<std::size_t> used_;
  std::vector<double> root_weight_;
};

}  // namespace

HomogeneousFit fit_homogeneous(Objective& objective) {
  LogResidual residual(objective);
  const forward::GridSetup& setup = objective.problem().setup;
  const double thickness = setup.shape.extent(axis_of(setup.lit_face)) * setup.shape.voxel_mm;

  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  Residuals at;
  for (const double kappa : {0.005, 0.02, 0.08, 0.3}) {
    for (const double attenuation : {0.1, 0.5, 2.0, 6.0}) {
      // The second guess is the thickness in diffusion lengths, √(μ/κ) ℓ.
      const double mu = attenuation * attenuation * kappa;
      const Eigen::Vector2d guess(std::log(kappa * thickness), std::log(mu / thickness));
      if (3.0 * kappa * mu >= 0.5) continue;  // hardly scatters: no diffusion
      const Residuals r = residual(guess);
      if (r.square < at.square) {
        at = r;
        p = guess;
      }
    }
  }
  if (!std::isfinite(at.square)) {
    throw InputError("the diffusion solver converges for none of the homogeneous starting guesses");
  }

  HomogeneousFit fit;
  double damping = 1e-2;
  for (int iteration = 0; iteration < max_iterations && !fit.converged; ++iteration) {
    constexpr double difference = 1e-2;
    Eigen::MatrixXd jacobian(at.value.size(), 2);
    for (int k = 0; k < 2; ++k) {
      Eigen::Vector2d moved = p;
      moved[k] += difference;
      const Residuals r = residual(moved);
      check(r.value.size() == at.value.size(), "a small step left the range of the solver");
      jacobian.col(k) = (r.value - at.value) / difference;
    }
    const Eigen::Matrix2d normal = jacobian.transpose() * jacobian;
    const Eigen::Vector2d slope = jacobian.transpose() * at.value;
    bool lower = false;
    for (int attempt = 0; attempt < 8 && !lower; ++attempt) {
      Eigen::Matrix2d damped = normal;
      damped.diagonal() +=
          damping * normal.diagonal() + Eigen::Vector2d::Constant(1e-9 * normal.trace());
      Eigen::Vector2d step = -damped.ldlt().solve(slope);
      step = step.cwiseMax(-1.5).cwiseMin(1.5);
      fit.converged = step.cwiseAbs().maxCoeff() < step_tolerance;
      if (fit.converged) break;
      const Residuals r = residual(p + step);
      lower = r.square < at.square;
      if (lower) {
        p += step;
        at = r;
        damping = std::max(1e-6, 0.2 * damping);
      } else {
        damping *= 8.0;
      }
    }
    if (!lower) break;
  }
  fit.kappa = std::exp(p[0]);
  fit.mu = std::exp(p[1]);
  fit.log_residual = residual.root_mean_square(at.square);
  fit.evaluations = residual.evaluations;
  return fit;
}

}  // namespace kappamu::inverse
