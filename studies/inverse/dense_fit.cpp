#include "studies/inverse/dense_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/progress.h"
#include "inverse/problem/problem.h"

namespace kappamu::studies {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using inverse::CoefficientPair;

namespace {

/// ‖∇J‖ of a minimum against that of the start.
constexpr double gradient_reduction = 1e-5;
constexpr int most_iterations = 60;
constexpr double shortest_step = 1e-3;
/// Change of a coefficient [log units] over which J stays.
constexpr double linear = 0.02;

VectorXd weighted_residual(const inverse::Objective& objective, const std::vector<double>& data) {
  const std::vector<double> prediction = objective.prediction();
  const std::vector<double>& weight = objective.problem().weight;
  VectorXd residual(static_cast<Index>(data.size()));
  for (std::size_t i = 0; i < data.size(); ++i) {
    residual[static_cast<Index>(i)] = std::sqrt(weight[i]) * (prediction[i] - data[i]);
  }
  return residual;
}

}  // namespace

CoefficientPair fields_of(const VectorXd& u) {
  const auto cells = static_cast<std::ptrdiff_t>(u.size() / 2);
  return {{u.begin(), u.begin() + cells}, {u.begin() + cells, u.end()}};
}

VectorXd joined(const CoefficientPair& fields) {
  VectorXd u(static_cast<Index>(fields.log_kappa.size() + fields.log_mu.size()));
  std::copy(fields.log_mu.begin(), fields.log_mu.end(),
            std::copy(fields.log_kappa.begin(), fields.log_kappa.end(), u.begin()));
  return u;
}

DenseFit::DenseFit(const SurfaceMeasurements& measurements, int channel,
                   const inverse::FitOptions& options)
    : channel_(channel), options_(options) {
  options_.path.model = inverse::Model::volume;
  Progress silent;
  const inverse::ChannelFit start =
      inverse::fit_channel(measurements, channel, options_, inverse::Checkpoint{}, silent);
  const double thickness =
      measurements.grid.extent(axis_of(measurements.lit_face)) * measurements.grid.voxel_mm;
  prior_ = {start.report.weight, options_.regulariser.anchor_length * thickness};
  anchor_ = {std::log(start.report.homogeneous_kappa), std::log(start.report.homogeneous_mu),
             prior_.anchor_length_mm};
  inverse::Problem problem = inverse::make_problem(measurements, channel, options_.data.convention,
                                                   options_.data.model_error);
  const inverse::Refinement finer = inverse::refine(problem);
  objective_ = std::make_unique<inverse::Objective>(std::move(problem), options_.solver.backend);
  const CoefficientPair fields = inverse::to_fields(start.medium);
  objective_->refresh_correction(finer, fields);
  fitted_ = joined(fields);
  build_matrices();
  const VectorXd minimum = minimise(*objective_, objective_->problem().data);
  const bool moved = (minimum - fitted_).cwiseAbs().maxCoeff() > linear;
  fitted_ = minimum;
  if (moved) build_matrices();
  unconverged_ = 0.0;
}

inverse::Objective& DenseFit::objective() {
  objective_->value(fields_of(fitted_));
  return *objective_;
}

/// At the fields of the last value().
VectorXd DenseFit::gradient(inverse::Objective& objective, const std::vector<double>& data) const {
  const VectorXd residual = weighted_residual(objective, data);
  return joined(objective.jacobian_transpose({residual.begin(), residual.end()})) +
         prior_.weight * joined(inverse::roughness(objective.space(), fields_, anchor_).gradient);
}

double DenseFit::value(inverse::Objective& objective, const std::vector<double>& data,
                       const VectorXd& u) {
  fields_ = fields_of(u);
  if (!std::isfinite(objective.value(fields_))) return std::numeric_limits<double>::infinity();
  return 0.5 * weighted_residual(objective, data).squaredNorm() +
         prior_.weight * inverse::roughness(objective.space(), fields_, anchor_).value;
}

/// The minimum of the full objective by L-BFGS that starts from the fitted block's covariance:
/// where its gradient vanishes. With that covariance alone the curved valley of κ against μ took
/// more steps than patience.
VectorXd DenseFit::minimise(inverse::Objective& objective, const std::vector<double>& data) {
  VectorXd u = fitted_;
  double here = value(objective, data, u);
  VectorXd g = gradient(objective, data);
  const double first = g.norm();
  std::vector<VectorXd> moves, changes;  // of u and of g
  for (int k = 0; k < most_iterations && g.norm() > gradient_reduction * first; ++k) {
    VectorXd step = g;
    std::vector<double> share(moves.size());
    for (std::size_t i = moves.size(); i-- > 0;) {
      share[i] = moves[i].dot(step) / moves[i].dot(changes[i]);
      step -= share[i] * changes[i];
    }
    step = covariance_ * step;
    for (std::size_t i = 0; i < moves.size(); ++i) {
      step += (share[i] - changes[i].dot(step) / moves[i].dot(changes[i])) * moves[i];
    }
    double length = 1.0;
    double there = value(objective, data, u - step);
    while (!(there < here) && length > shortest_step) {
      length *= 0.5;
      there = value(objective, data, u - length * step);
    }
    if (!(there < here)) break;  // rounding allows no better
    const VectorXd before = g;
    u -= length * step;
    here = there;
    g = gradient(objective, data);
    if (step.dot(before - g) <= 0.0) continue;
    moves.push_back(-length * step);
    changes.push_back(g - before);
  }
  unconverged_ = std::max(unconverged_, g.norm() / first);
  return u;
}

void DenseFit::build_matrices() {
  const Index n = fitted_.size();
  objective_->value(fields_of(fitted_));
  jacobian_.resize(static_cast<Index>(objective_->problem().data.size()), n);
  precision_.resize(n, n);
  for (Index k = 0; k < n; ++k) {
    const CoefficientPair unit = fields_of(VectorXd::Unit(n, k));
    const std::vector<double> column = objective_->jacobian(unit);
    jacobian_.col(k) = Eigen::Map<const VectorXd>(column.data(), jacobian_.rows());
    precision_.col(k) =
        prior_.weight *
        joined(inverse::smoothing_product(objective_->space(), prior_.anchor_length_mm, {}, unit));
  }
  MatrixXd hessian = precision_;
  hessian.selfadjointView<Eigen::Lower>().rankUpdate(jacobian_.transpose());
  covariance_ = hessian.selfadjointView<Eigen::Lower>().llt().solve(MatrixXd::Identity(n, n));
}

VectorXd DenseFit::change(const std::vector<double>& data) const {
  const inverse::Problem& problem = objective_->problem();
  VectorXd weighted(jacobian_.rows());
  for (std::size_t i = 0; i < data.size(); ++i) {
    weighted[static_cast<Index>(i)] = std::sqrt(problem.weight[i]) * (data[i] - problem.data[i]);
  }
  return covariance_ * (jacobian_.transpose() * weighted);
}

/// The fit's own objective with other light and values.
std::unique_ptr<inverse::Objective> DenseFit::exchanged(
    const SurfaceMeasurements& measurements) const {
  const inverse::Problem& here = objective_->problem();
  inverse::Problem other = inverse::make_problem(measurements, channel_, options_.data.convention,
                                                 options_.data.model_error);
  for (std::size_t i = 0; i < other.weight.size(); ++i) {
    other.weight[i] = other.weight[i] > 0.0 ? here.weight[i] : 0.0;
  }
  auto objective = std::make_unique<inverse::Objective>(std::move(other), options_.solver.backend);
  objective->set_correction(objective_->correction());
  return objective;
}

VectorXd DenseFit::change(const SurfaceMeasurements& measurements) {
  const auto other = exchanged(measurements);
  other->value(fields_of(fitted_));
  const VectorXd model_residual = weighted_residual(*other, other->problem().data) -
                                  weighted_residual(objective(), objective_->problem().data);
  return -(covariance_ * (jacobian_.transpose() * model_residual));
}

VectorXd DenseFit::refitted(const std::vector<double>& data) {
  return minimise(*objective_, data) - fitted_;
}

VectorXd DenseFit::refitted(const SurfaceMeasurements& measurements) {
  const auto other = exchanged(measurements);
  return minimise(*other, other->problem().data) - fitted_;
}

Variances DenseFit::propagated(const SurfaceMeasurements& measurements) const {
  const std::vector<double> weight =
      inverse::make_problem(measurements, channel_, options_.data.convention, {0.0, 0.0}).weight;
  VectorXd scale = VectorXd::Zero(jacobian_.rows());
  for (std::size_t i = 0; i < weight.size(); ++i) {
    if (weight[i] > 0.0) {
      scale[static_cast<Index>(i)] = std::sqrt(objective_->problem().weight[i] / weight[i]);
    }
  }
  const MatrixXd root = covariance_ * jacobian_.transpose() * scale.asDiagonal();
  return root.rowwise().squaredNorm();
}

}  // namespace kappamu::studies
