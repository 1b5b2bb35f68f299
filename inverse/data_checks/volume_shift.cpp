#include "inverse/data_checks/volume_shift.h"

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
/// Share of S that the last step of conjugate gradients may still have taken away.
constexpr double small_change = 0.01;

/// Derivatives of `root_weight` times the prediction by shifts along u and v [voxels].
Eigen::MatrixX2d by_shift(const Problem& problem, const std::vector<double>& prediction,
                          const std::vector<double>& root_weight) {
  const FaceShape face = problem.seen_shape();
  Eigen::MatrixX2d columns(static_cast<Eigen::Index>(prediction.size()), 2);
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
            -root_weight[i] *
            Eigen::RowVector2d(slope(v * face.nu + left, v * face.nu + right, right - left),
                               slope(below * face.nu + u, above * face.nu + u, above - below));
      }
    }
  }
  return columns;
}

/// α R′ of H1.
CoefficientPair smoothing_gradient(CoefficientPair fields, const GridShape& shape,
                                   const Prior& prior) {
  for (Vector* values : {&fields.log_kappa, &fields.log_mu}) {
    const double mean =
        std::accumulate(values->begin(), values->end(), 0.0) / static_cast<double>(values->size());
    for (double& v : *values) v = prior.weight * (v - mean);
  }
  return smoothing_product(shape, prior.thickness_mm, prior.anchor_length_mm, {}, fields);
}

}  // namespace

VolumeShift volume_shift(Objective& objective, const CoefficientPair& fields, const Prior& prior,
                         int steps, std::uint64_t seed) {
  const Problem& problem = objective.problem();
  const std::vector<double> prediction = objective.prediction();
  const std::vector<double> root_weight = objective.root_weight();
  const Eigen::MatrixX2d columns = by_shift(problem, prediction, root_weight);
  Eigen::VectorXd residual(columns.rows());
  for (std::size_t i = 0; i < prediction.size(); ++i) {
    residual[static_cast<Eigen::Index>(i)] = root_weight[i] * (problem.data[i] - prediction[i]);
  }
  const PosteriorHessian hessian(objective, prior, probes, seed);
  Eigen::MatrixX2d weighed(columns.rows(), 2);
  for (Eigen::Index k = 0; k < 2; ++k) {
    std::vector<double> column(columns.col(k).begin(), columns.col(k).end());
    objective.weigh(column);
    weighed.col(k) = Eigen::Map<const Eigen::VectorXd>(column.data(), weighed.rows());
  }
  Eigen::Matrix2d s = columns.transpose() * weighed;
  std::array<Eigen::VectorXd, 2> pulls;
  std::array<GradientSolution, 2> solutions;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    const Eigen::VectorXd data = weighed.col(column);
    pulls[k] = hessian.gradient(objective.jacobian_transpose({data.begin(), data.end()}));
    // Until bᵀ H⁻¹ b grows by less than a share of what FᵀF is above it.
    solutions[k] = conjugate_gradients([&](const Eigen::VectorXd& z) { return hessian.product(z); },
                                       pulls[k], steps,
                                       [most = s(column, column)](const GradientStep& step) {
                                         return step.gain < small_change * (most - step.energy);
                                       });
  }
  // Corrected by the residuals, what is left of both errors is of second order.
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t l = 0; l < 2; ++l) {
      s(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)) -=
          pulls[k].dot(solutions[l].x) + solutions[k].x.dot(solutions[l].rest);
    }
  }
  const Eigen::Matrix2d covariance = solve_symmetric(s, Eigen::Matrix2d::Identity());
  const Eigen::VectorXd rise =
      hessian.gradient(objective.gradient()) +
      hessian.gradient(smoothing_gradient(fields, problem.setup.shape, prior));
  Eigen::Vector2d pull = weighed.transpose() * residual;
  pull += Eigen::Vector2d(solutions[0].x.dot(rise), solutions[1].x.dot(rise));
  const Eigen::Vector2d f = covariance * pull;
  return {{f[0], std::sqrt(covariance(0, 0))}, {f[1], std::sqrt(covariance(1, 1))}};
}

}  // namespace kappamu::inverse
