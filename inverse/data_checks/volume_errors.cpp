#include "inverse/data_checks/volume_errors.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <vector>

#include "core/numbers/conjugate_gradients.h"
#include "core/numbers/linear_algebra.h"
#include "inverse/defaults.h"
#include "inverse/optimise/lateral_hessian.h"
#include "inverse/regulariser/roughness.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::volume_errors;

/// Columns: shifts along u and v, and the logarithm of the scale where it can be known.
constexpr Eigen::Index shifts = 2, scale = 2;
/// Share of S by which the last step of conjugate gradients may still lower it. The volume absorbs
/// nearly all of a scale, so each step lowers its S by little.
constexpr std::array<double, shifts + 1> small_change{0.01, 0.01, 0.001};

/// Derivatives of `root_weight` times the prediction by shifts along u and v [voxels] and by the
/// logarithm of its scale.
Eigen::MatrixXd by_error(const Problem& problem, const std::vector<double>& prediction,
                         const std::vector<double>& root_weight) {
  const FaceShape face = problem.seen_shape();
  const bool scaled = problem.seen_faces.empty() && problem.setup.lit_face != problem.seen_face;
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(prediction.size()), shifts + (scaled ? 1 : 0));
  std::size_t i = 0;
  for (int m = 0; m < problem.patterns; ++m) {
    const double* map = prediction.data() + static_cast<std::size_t>(m) * face.cells();
    const auto slope = [&](int low, int high, int apart) {
      return apart > 0 ? (map[high] - map[low]) / apart : 0.0;
    };
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u, ++i) {
        const int left = std::max(u - 1, 0), right = std::min(u + 1, face.nu - 1);
        const int below = std::max(v - 1, 0), above = std::min(v + 1, face.nv - 1);
        const auto row = static_cast<Eigen::Index>(i);
        columns(row, 0) = -slope(v * face.nu + left, v * face.nu + right, right - left);
        columns(row, 1) = -slope(below * face.nu + u, above * face.nu + u, above - below);
        if (scaled) columns(row, scale) = prediction[i];
        columns.row(row) *= root_weight[i];
      }
    }
  }
  return columns;
}

/// α R of H1, drawn to the fields' means, and its gradient.
Roughness smoothing(const CoefficientPair& fields, const MediumSpace& space, const Prior& prior) {
  const auto mean = [](const Vector& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  };
  const Anchor anchor{mean(fields.log_kappa), mean(fields.log_mu), prior.anchor_length_mm};
  Roughness r = roughness(space, fields, anchor);
  r.value *= prior.weight;
  for (Vector* values : {&r.gradient.log_kappa, &r.gradient.log_mu}) {
    for (double& v : *values) v *= prior.weight;
  }
  return r;
}

/// ½ f²/σ² of an estimate's value and variance, or of pull S f and S; less than 0 where f is.
double fall(double value, double variance) {
  return 0.5 * value * std::abs(value) / variance;
}

}  // namespace

VolumeErrors volume_errors(Objective& objective, const CoefficientPair& fields, const Prior& prior,
                           const ErrorSteps& steps, std::uint64_t seed) {
  const Problem& problem = objective.problem();
  const std::vector<double> prediction = objective.prediction();
  const std::vector<double> root_weight = objective.root_weight();
  const Eigen::MatrixXd columns = by_error(problem, prediction, root_weight);
  const Eigen::Index errors = columns.cols();
  Eigen::VectorXd residual(columns.rows());
  for (std::size_t i = 0; i < prediction.size(); ++i) {
    residual[static_cast<Eigen::Index>(i)] = root_weight[i] * (problem.data[i] - prediction[i]);
  }
  const MediumSpace& space = objective.space();
  const Basis basis =
      posterior_metric(prior, space, prior_blocks(random_rows(objective, probes, seed), space));
  const auto gradient = [&](const CoefficientPair& by_field) {
    const Vector z = basis.gradient(by_field);
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(z.data(), std::ssize(z)));
  };
  const auto product = [&](const Eigen::VectorXd& z) {
    return gradient(hessian_product(objective, prior, basis.to_fields({z.begin(), z.end()})));
  };
  Eigen::MatrixXd weighed(columns.rows(), errors);
  for (Eigen::Index k = 0; k < errors; ++k) {
    std::vector<double> column(columns.col(k).begin(), columns.col(k).end());
    objective.weigh(column);
    weighed.col(k) = Eigen::Map<const Eigen::VectorXd>(column.data(), weighed.rows());
  }
  Eigen::MatrixXd s = columns.transpose() * weighed;
  Eigen::VectorXd pull = weighed.transpose() * residual;
  const Roughness rough = smoothing(fields, space, prior);
  const Eigen::VectorXd rise = gradient(objective.gradient()) + gradient(rough.gradient);
  std::vector<Eigen::VectorXd> pulls;
  std::vector<GradientSolution> solutions;
  for (Eigen::Index k = 0; k < errors; ++k) {
    const Eigen::VectorXd data = weighed.col(k);
    pulls.push_back(gradient(objective.jacobian_transpose({data.begin(), data.end()})));
    int taken = 0;
    const auto enough = [&](const GradientStep& step) {
      const double left = s(k, k) - step.energy;
      // Until bᵀ H⁻¹ b grows by less than a share of what FᵀF is above it.
      return step.gain < small_change[static_cast<std::size_t>(k)] * left ||
             (++taken == steps.early && k == scale &&
              fall(pull[k] + step.x.dot(rise), left) < steps.least_gain * rough.value);
    };
    solutions.push_back(conjugate_gradients(product, pulls.back(), steps.most, enough));
  }
  // With the residuals' correction the remaining errors of S are of second order.
  for (Eigen::Index k = 0; k < errors; ++k) {
    const auto row = static_cast<std::size_t>(k);
    for (Eigen::Index l = 0; l < errors; ++l) {
      const GradientSolution& other = solutions[static_cast<std::size_t>(l)];
      s(k, l) -= pulls[row].dot(other.x) + solutions[row].x.dot(other.rest);
    }
    pull[k] += solutions[row].x.dot(rise);
  }
  const Eigen::MatrixXd covariance = solve_symmetric(s, Eigen::MatrixXd::Identity(errors, errors));
  const auto estimate = [&, f = Eigen::VectorXd(covariance * pull)](Eigen::Index k) {
    return Estimate{f[k], std::sqrt(covariance(k, k))};
  };
  VolumeErrors found{.shift_u = estimate(0), .shift_v = estimate(1), .log_scale = {}};
  if (errors > scale) {
    found.log_scale = estimate(scale);
    const Estimate& f = *found.log_scale;
    if (rough.value > 0.0) {
      found.scale_gain = fall(f.value, f.error * f.error) / rough.value;
    }
  }
  return found;
}

}  // namespace kappamu::inverse
