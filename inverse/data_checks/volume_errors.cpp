#include "inverse/data_checks/volume_errors.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/numbers/conjugate_gradients.h"
#include "core/numbers/linear_algebra.h"
#include "inverse/regulariser/roughness.h"
#include "inverse/uncertainty/posterior_hessian.h"

namespace kappamu::inverse {

namespace {

constexpr int probes = 4;
constexpr Eigen::Index errors = 3;  ///< shifts along u and v, logarithm of the scale
using Columns = Eigen::Matrix<double, Eigen::Dynamic, errors>;
using Square = Eigen::Matrix<double, errors, errors>;
/// Share of S that the last step of conjugate gradients may still have taken away: of a scale's S,
/// of which the volume absorbs all but thousandths, each step takes little.
constexpr std::array<double, errors> small_change{0.01, 0.01, 0.001};

/// Derivatives of `root_weight` times the prediction by shifts along u and v [voxels] and by the
/// logarithm of its scale.
Columns by_error(const Problem& problem, const std::vector<double>& prediction,
                 const std::vector<double>& root_weight) {
  const FaceShape face = problem.seen_shape();
  Columns columns(static_cast<Eigen::Index>(prediction.size()), errors);
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
        columns.row(static_cast<Eigen::Index>(i)) =
            root_weight[i] *
            Eigen::RowVector3d(-slope(v * face.nu + left, v * face.nu + right, right - left),
                               -slope(below * face.nu + u, above * face.nu + u, above - below),
                               prediction[i]);
      }
    }
  }
  return columns;
}

/// α R of H1, drawn to the fields' means, and its gradient.
Roughness smoothing(const CoefficientPair& fields, const GridShape& shape, const Prior& prior) {
  const auto mean = [](const Vector& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  };
  const Anchor anchor{mean(fields.log_kappa), mean(fields.log_mu), prior.anchor_length_mm};
  Roughness r = roughness(shape, prior.thickness_mm, fields, anchor);
  r.value *= prior.weight;
  for (Vector* values : {&r.gradient.log_kappa, &r.gradient.log_mu}) {
    for (double& v : *values) v *= prior.weight;
  }
  return r;
}

}  // namespace

VolumeErrors volume_errors(Objective& objective, const CoefficientPair& fields, const Prior& prior,
                           int steps, std::uint64_t seed) {
  const Problem& problem = objective.problem();
  const std::vector<double> prediction = objective.prediction();
  const std::vector<double> root_weight = objective.root_weight();
  const Columns columns = by_error(problem, prediction, root_weight);
  Eigen::VectorXd residual(columns.rows());
  for (std::size_t i = 0; i < prediction.size(); ++i) {
    residual[static_cast<Eigen::Index>(i)] = root_weight[i] * (problem.data[i] - prediction[i]);
  }
  const PosteriorHessian hessian(objective, prior, probes, seed);
  Columns weighed(columns.rows(), errors);
  for (Eigen::Index k = 0; k < errors; ++k) {
    std::vector<double> column(columns.col(k).begin(), columns.col(k).end());
    objective.weigh(column);
    weighed.col(k) = Eigen::Map<const Eigen::VectorXd>(column.data(), weighed.rows());
  }
  Square s = columns.transpose() * weighed;
  std::array<Eigen::VectorXd, errors> pulls;
  std::array<GradientSolution, errors> solutions;
  for (std::size_t k = 0; k < errors; ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    const Eigen::VectorXd data = weighed.col(column);
    pulls[k] = hessian.gradient(objective.jacobian_transpose({data.begin(), data.end()}));
    // Until bᵀ H⁻¹ b grows by less than a share of what FᵀF is above it.
    solutions[k] = conjugate_gradients([&](const Eigen::VectorXd& z) { return hessian.product(z); },
                                       pulls[k], steps,
                                       [&, most = s(column, column)](const GradientStep& step) {
                                         return step.gain < small_change[k] * (most - step.energy);
                                       });
  }
  const Roughness rough = smoothing(fields, problem.setup.shape, prior);
  const Eigen::VectorXd rise =
      hessian.gradient(objective.gradient()) + hessian.gradient(rough.gradient);
  Eigen::Vector<double, errors> pull = weighed.transpose() * residual;
  // Corrected by the residuals, what is left of the errors of S is of second order.
  for (std::size_t k = 0; k < errors; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    for (std::size_t l = 0; l < errors; ++l) {
      s(row, static_cast<Eigen::Index>(l)) -=
          pulls[k].dot(solutions[l].x) + solutions[k].x.dot(solutions[l].rest);
    }
    pull[row] += solutions[k].x.dot(rise);
  }
  const Eigen::MatrixXd covariance = solve_symmetric(s, Square::Identity());
  const auto estimate = [&, f = Eigen::VectorXd(covariance * pull)](Eigen::Index k) {
    return Estimate{f[k], std::sqrt(covariance(k, k))};
  };
  const Estimate scale = estimate(2);
  const double fall = 0.5 * scale.value * std::abs(scale.value) / (scale.error * scale.error);
  return {estimate(0), estimate(1), scale, rough.value > 0.0 ? fall / rough.value : 0.0};
}

}  // namespace kappamu::inverse
