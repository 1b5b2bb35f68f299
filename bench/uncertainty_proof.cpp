#include "bench/uncertainty_proof.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/progress.h"
#include "inverse/fit.h"
#include "inverse/problem.h"

namespace kappamu::bench {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using inverse::CoefficientPair;

/// ‖∇J‖ of a minimum against that of the start.
constexpr double gradient_reduction = 1e-5;
constexpr int most_iterations = 60;
constexpr double shortest_step = 1e-3;

/// Smooth fields with an absorbing box; relative position decides, so every grid shows the same.
CoefficientPair medium(const GridShape& shape) {
  TruthSpec spec;
  spec.contrast = 2.0;
  spec.seed = 3;
  return make_truth(shape, spec);
}

VectorXd joined(const CoefficientPair& fields) {
  VectorXd u(static_cast<Index>(fields.log_kappa.size() + fields.log_mu.size()));
  std::copy(fields.log_mu.begin(), fields.log_mu.end(),
            std::copy(fields.log_kappa.begin(), fields.log_kappa.end(), u.begin()));
  return u;
}

VectorXd normals(Noise& noise, Index count) {
  VectorXd values(count);
  for (double& x : values) x = noise.normal();
  return values;
}

inverse::Problem exact_problem(const ProofOptions& options, SurfaceMeasurements& measurements) {
  Block block;
  block.grid = options.grid;
  block.noise = options.noise;
  measurements = expose_patches(block, medium(options.grid.refined(2)), options.side);
  const std::vector<float> exact = measurements.value;
  add_noise(measurements, options.noise, options.seed);  // for the variances it states
  measurements.value = exact;
  return inverse::make_problem(measurements, 0, forward::Convention::physical, {0.0, 0.0});
}

}  // namespace

Proof::Proof(const ProofOptions& options) : options_(options), noise_(options.seed) {
  SurfaceMeasurements measurements;
  inverse::Problem problem = exact_problem(options, measurements);
  exact_ = problem.data;
  inverse::Backend backend;
  backend.device = options.device;
  backend.precision = forward::Precision::double_precision;
  backend.solve = {1e-9, 500};
  inverse::FitOptions fit;
  fit.model = inverse::Model::volume;
  fit.weight = options.weight;
  fit.model_error = {0.0, 0.0};
  fit.backend = backend;
  Progress silent;
  const inverse::ChannelFit start =
      inverse::fit_channel(measurements, 0, fit, inverse::Checkpoint{}, silent);
  const double thickness = options.grid.extent(2) * options.grid.voxel_mm;
  weights_ = {options.weight, options.weight, thickness, fit.anchor_length * thickness};
  anchor_ = {std::log(start.report.homogeneous_kappa), std::log(start.report.homogeneous_mu),
             weights_.anchor_length_mm};
  const inverse::Refinement finer = inverse::refine(problem);
  objective_ = std::make_unique<inverse::Objective>(std::move(problem), backend);
  CoefficientPair fields;
  for (const double k : start.medium.kappa.values()) fields.log_kappa.push_back(std::log(k));
  for (const double m : start.medium.mu.values()) fields.log_mu.push_back(std::log(m));
  objective_->refresh_correction(finer, fields);
  fitted_ = joined(fields);
  build_matrices();
  fitted_ = minimise(exact_);
  build_matrices();
  unconverged_ = 0.0;
}

CoefficientPair Proof::fields_of(const VectorXd& u) const {
  const auto cells = static_cast<std::ptrdiff_t>(u.size() / 2);
  return {{u.begin(), u.begin() + cells}, {u.begin() + cells, u.end()}};
}

/// At the fields of the last value().
VectorXd Proof::gradient(const std::vector<double>& data) {
  std::vector<double> residual = objective_->prediction();
  for (std::size_t i = 0; i < residual.size(); ++i) {
    residual[i] = std::sqrt(objective_->problem().weight[i]) * (residual[i] - data[i]);
  }
  return joined(objective_->jacobian_transpose(residual)) +
         options_.weight *
             joined(inverse::roughness(options_.grid, weights_.thickness_mm, fields_, anchor_)
                        .gradient);
}

double Proof::value(const std::vector<double>& data, const VectorXd& u) {
  fields_ = fields_of(u);
  if (!std::isfinite(objective_->value(fields_))) return std::numeric_limits<double>::infinity();
  const std::vector<double> prediction = objective_->prediction();
  double chi2 = 0.0;
  for (std::size_t i = 0; i < data.size(); ++i) {
    chi2 += objective_->problem().weight[i] * std::pow(prediction[i] - data[i], 2);
  }
  return 0.5 * chi2 +
         options_.weight *
             inverse::roughness(options_.grid, weights_.thickness_mm, fields_, anchor_).value;
}

/// The minimum of the full objective by L-BFGS that starts from the fitted block's covariance:
/// where its gradient vanishes. With that covariance alone the curved valley of κ against μ took
/// more steps than patience.
VectorXd Proof::minimise(const std::vector<double>& data) {
  VectorXd u = fitted_;
  double here = value(data, u);
  VectorXd g = gradient(data);
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
    double there = value(data, u - step);
    while (!(there < here) && length > shortest_step) {
      length *= 0.5;
      there = value(data, u - length * step);
    }
    if (!(there < here)) break;  // rounding allows no better
    const VectorXd before = g;
    u -= length * step;
    here = there;
    g = gradient(data);
    if (step.dot(before - g) <= 0.0) continue;
    moves.push_back(-length * step);
    changes.push_back(g - before);
  }
  unconverged_ = std::max(unconverged_, g.norm() / first);
  return u;
}

void Proof::build_matrices() {
  const Index n = fitted_.size();
  objective_->value(fields_of(fitted_));
  jacobian_.resize(static_cast<Index>(exact_.size()), n);
  precision_.resize(n, n);
  for (Index k = 0; k < n; ++k) {
    const CoefficientPair unit = fields_of(VectorXd::Unit(n, k));
    const std::vector<double> column = objective_->jacobian(unit);
    jacobian_.col(k) = Eigen::Map<const VectorXd>(column.data(), jacobian_.rows());
    precision_.col(k) =
        options_.weight * joined(inverse::roughness(options_.grid, weights_.thickness_mm, unit,
                                                    inverse::Anchor{0.0, 0.0, anchor_.length_mm})
                                     .gradient);
  }
  MatrixXd data_part(n, n);
  data_part.setZero();
  data_part.selfadjointView<Eigen::Lower>().rankUpdate(jacobian_.transpose());
  data_part = MatrixXd(data_part.selfadjointView<Eigen::Lower>());
  hessian_ = data_part + precision_;
  const MatrixXd identity = MatrixXd::Identity(n, n);
  covariance_ = hessian_.llt().solve(identity);
  posterior_ = covariance_.diagonal();
  prior_ = precision_.llt().solve(identity).diagonal();
  noise_part_ = posterior_ - (covariance_ * precision_).cwiseProduct(covariance_).rowwise().sum();
  eigenvalues_.resize(0);
}

Variances Proof::sampled_noise_part(int count) {
  VectorXd sum = VectorXd::Zero(unknowns());
  VectorXd squares = sum;
  for (int k = 0; k < count; ++k) {
    std::vector<double> data = exact_;
    for (std::size_t i = 0; i < data.size(); ++i) {
      const double weight = objective_->problem().weight[i];
      if (weight > 0.0) data[i] += noise_.normal() / std::sqrt(weight);
    }
    const VectorXd change = minimise(data) - fitted_;
    sum += change;
    squares += change.cwiseAbs2();
  }
  return (squares - sum.cwiseAbs2() / count) / (count - 1);
}

Variances Proof::sampled_posterior(int count) {
  const Eigen::LLT<MatrixXd> root(precision_);  // P = L Lᵀ: L⁻ᵀ ξ has covariance P⁻¹
  VectorXd squares = VectorXd::Zero(unknowns());
  for (int k = 0; k < count; ++k) {
    const VectorXd truth = root.matrixU().solve(normals(noise_, unknowns()));
    const VectorXd data = jacobian_ * truth + normals(noise_, jacobian_.rows());
    squares += (covariance_ * (jacobian_.transpose() * data) - truth).cwiseAbs2();
  }
  return squares / count;
}

Variances Proof::low_rank_posterior(Index rank) {
  const Eigen::LLT<MatrixXd> root(precision_);
  if (eigenvalues_.size() == 0) {
    const MatrixXd half = root.matrixL().solve(jacobian_.transpose());  // L⁻¹ JᵀW^½
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(half * half.transpose());
    eigenvalues_ = eigen.eigenvalues().reverse();
    directions_ = root.matrixU().solve(eigen.eigenvectors().rowwise().reverse());
  }
  const auto shrunk = eigenvalues_.head(rank).array() / (1.0 + eigenvalues_.head(rank).array());
  return prior_ - directions_.leftCols(rank).cwiseAbs2() * shrunk.matrix();
}

Variances Proof::estimated_posterior(const inverse::UncertaintyOptions& options, int& solves) {
  objective_->value(fields_of(fitted_));
  const inverse::Uncertainty found =
      inverse::estimate_uncertainty(*objective_, weights_, std::nullopt, options, options_.seed);
  solves = found.report.solves;
  const Index cells = unknowns() / 2;
  Variances variances(unknowns());
  for (Index i = 0; i < cells; ++i) {
    const auto at = static_cast<std::size_t>(i);
    variances[i] = std::pow(found.log_kappa_std[at], 2);
    variances[cells + i] = std::pow(found.log_mu_std[at], 2);
  }
  return variances;
}

DeviationRatio deviation_ratio(const Variances& found, const Variances& expected,
                               const std::vector<bool>& use) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < use.size(); ++i) {
    const auto at = static_cast<Index>(i);
    if (use[i]) ratios.push_back(std::sqrt(found[at] / expected[at]));
  }
  if (ratios.empty()) return {};
  std::sort(ratios.begin(), ratios.end());
  const auto quantile = [&](double share) {
    return ratios[static_cast<std::size_t>(std::lround(share * (ratios.size() - 1.0)))];
  };
  return {quantile(0.05), quantile(0.5), quantile(0.95), ratios.size()};
}

}  // namespace kappamu::bench
