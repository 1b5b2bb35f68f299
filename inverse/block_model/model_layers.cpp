#include "inverse/block_model/model_layers.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "inverse/problem/expected_blocks.h"

namespace kappamu::inverse {

namespace {

constexpr int max_steps = 25;
/// A step that keeps less than this of its promise is bent back into the valley it left (geodesic
/// acceleration, Transtrum & Sethna 2012), if by less than this share of its length.
constexpr double kept_well = 0.75;
constexpr double most_bend = 0.75;
/// A step that promises less of χ² moves no unknown by more than 0.3 of its standard error.
constexpr double negligible = 0.1;
/// Far above the noise, where the model will be rejected anyway, this share of χ² is as good.
constexpr double negligible_share = 2e-3;
/// No descent keeps so many times what its next step promises.
constexpr double most_kept = 3.0;

struct Trial {
  Eigen::VectorXd step;
  Eigen::VectorXd residual;
  double cost = 0.0;
};

int layer_of(const std::vector<int>& first, int slice) {
  const auto after = std::upper_bound(first.begin(), first.end(), slice);
  return static_cast<int>(after - first.begin()) - 1;
}

}  // namespace

CoefficientPair to_fields(const LayeredMedium& medium, const GridShape& shape, int axis) {
  CoefficientPair fields{std::vector<double>(shape.cells()), std::vector<double>(shape.cells())};
  std::size_t i = 0;
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x, ++i) {
        const int slice = axis == 0 ? x : axis == 1 ? y : z;
        const auto layer = static_cast<std::size_t>(layer_of(medium.first, slice));
        fields.log_kappa[i] = medium.log_kappa[layer];
        fields.log_mu[i] = medium.log_mu[layer];
      }
    }
  }
  return fields;
}

LayeredMedium with_layers(const LayeredMedium& coarse, int layers, int depth) {
  check(layers >= 1 && layers <= depth, "a layer needs a slice");
  LayeredMedium fine;
  for (int l = 0; l < layers; ++l) fine.first.push_back((2 * l * depth + layers) / (2 * layers));
  for (int l = 0; l < layers; ++l) {
    const int end = l + 1 < layers ? fine.first[static_cast<std::size_t>(l) + 1] : depth;
    const int middle = (fine.first[static_cast<std::size_t>(l)] + end - 1) / 2;
    const auto from = static_cast<std::size_t>(layer_of(coarse.first, middle));
    fine.log_kappa.push_back(coarse.log_kappa[from]);
    fine.log_mu.push_back(coarse.log_mu[from]);
  }
  return fine;
}

LayerFitter::LayerFitter(Objective& objective, LayeredMedium start)
    : objective_(objective), first_(std::move(start.first)) {
  const Problem& problem = objective.problem();
  for (std::size_t i = 0; i < problem.weight.size(); ++i) {
    if (problem.weight[i] > 0.0) used_.push_back(i);
  }
  const auto layers = static_cast<Eigen::Index>(first_.size());
  p_.resize(2 * layers);
  p_.head(layers) = Eigen::Map<const Eigen::VectorXd>(start.log_kappa.data(), layers);
  p_.tail(layers) = Eigen::Map<const Eigen::VectorXd>(start.log_mu.data(), layers);
  make_prior();
}

void LayerFitter::make_prior() {
  const Eigen::Index layers = p_.size() / 2;
  prior_ = Eigen::MatrixXd::Zero(2 * (layers - 1) + 1, 2 * layers);
  for (Eigen::Index l = 0; l + 1 < layers; ++l) {
    for (const Eigen::Index half : {Eigen::Index{0}, layers}) {
      const Eigen::Index row = 2 * l + (half == 0 ? 0 : 1);
      prior_(row, half + l) = -1.0 / layer_spread;
      prior_(row, half + l + 1) = 1.0 / layer_spread;
    }
  }
  prior_.bottomRows(1).setConstant(1.0 / (absorption_spread * static_cast<double>(layers)));
  prior_value_ = Eigen::VectorXd::Zero(prior_.rows());
  prior_value_.tail(1) = prior_.bottomRows(1) * p_;
}

LayeredMedium LayerFitter::medium(const Eigen::VectorXd& p) const {
  const Eigen::Index layers = p.size() / 2;
  return {first_, std::vector<double>(p.data(), p.data() + layers),
          std::vector<double>(p.data() + layers, p.data() + 2 * layers)};
}

bool LayerFitter::evaluate(const Eigen::VectorXd& p, Eigen::VectorXd& residual) {
  const Problem& problem = objective_.problem();
  const GridShape& shape = problem.setup.shape;
  const double misfit =
      objective_.value(to_fields(medium(p), shape, axis_of(problem.setup.lit_face)));
  if (!std::isfinite(misfit)) return false;
  const std::vector<double> prediction = objective_.prediction();
  residual.resize(static_cast<Eigen::Index>(used_.size()));
  for (std::size_t k = 0; k < used_.size(); ++k) {
    const std::size_t i = used_[k];
    residual[static_cast<Eigen::Index>(k)] =
        std::sqrt(problem.weight[i]) * (prediction[i] - problem.data[i]);
  }
  return true;
}

/// At p_, where the objective was evaluated last.
void LayerFitter::differentiate() {
  const forward::GridSetup& setup = objective_.problem().setup;
  const int layers = static_cast<int>(first_.size());
  jacobian_.resize(static_cast<Eigen::Index>(used_.size()), p_.size());
  for (int k = 0; k < 2 * layers; ++k) {
    LayeredMedium direction{first_, std::vector<double>(first_.size(), 0.0),
                            std::vector<double>(first_.size(), 0.0)};
    (k < layers ? direction.log_kappa : direction.log_mu)[static_cast<std::size_t>(k % layers)] =
        1.0;
    const std::vector<double> change =
        objective_.jacobian(to_fields(direction, setup.shape, axis_of(setup.lit_face)));
    for (std::size_t i = 0; i < used_.size(); ++i) {
      jacobian_(static_cast<Eigen::Index>(i), k) = change[used_[i]];
    }
  }
}

Eigen::MatrixXd LayerFitter::normal() const {
  return jacobian_.transpose() * jacobian_ + prior_.transpose() * prior_;
}

Eigen::MatrixXd LayerFitter::slope_covariance(const ErrorCovariance& errors) const {
  return errors.between(jacobian_, used_) + prior_.transpose() * prior_;
}

std::vector<double> LayerFitter::residual_without_common(const ErrorCovariance& errors) {
  Eigen::VectorXd residual;
  if (!evaluate(p_, residual)) throw InputError("the diffusion solver fails at these layers");
  residual = errors.without_common(residual, jacobian_, used_);
  std::vector<double> all(objective_.problem().data.size(), 0.0);
  for (std::size_t k = 0; k < used_.size(); ++k) {
    all[used_[k]] = residual[static_cast<Eigen::Index>(k)];
  }
  return all;
}

Eigen::MatrixXd LayerFitter::covariance() {
  Eigen::VectorXd residual;
  if (!evaluate(p_, residual)) throw InputError("the diffusion solver fails at these layers");
  differentiate();
  return normal().ldlt().solve(Eigen::MatrixXd::Identity(p_.size(), p_.size()));
}

Eigen::MatrixXd LayerFitter::covariance(const ErrorCovariance& errors) {
  const Eigen::MatrixXd inverse = covariance();
  return inverse * slope_covariance(errors) * inverse;
}

LayeredFit LayerFitter::descend(double useful) {
  LayeredFit fit;
  Eigen::VectorXd residual;
  if (!evaluate(p_, residual)) {
    throw InputError("the diffusion solver fails at the starting layers");
  }
  const auto cost_of = [&](const Eigen::VectorXd& p, const Eigen::VectorXd& r) {
    return r.squaredNorm() + (prior_ * p - prior_value_).squaredNorm();
  };
  const auto noise = static_cast<double>(used_.size());
  double cost = cost_of(p_, residual);
  const auto attempt = [&](const Eigen::VectorXd& step) {
    Trial trial{step, {}, std::numeric_limits<double>::infinity()};
    if (evaluate(p_ + step, trial.residual)) trial.cost = cost_of(p_ + step, trial.residual);
    return trial;
  };
  double damping = 1e-2;
  double raise = 2.0;
  bool fresh = false;
  if (jacobian_.size() == 0) {
    differentiate();
    fresh = true;
  }
  for (; fit.steps < max_steps && !fit.converged; ++fit.steps) {
    const Eigen::VectorXd slope =
        jacobian_.transpose() * residual + prior_.transpose() * (prior_ * p_ - prior_value_);
    const Eigen::MatrixXd curvature = normal();
    Eigen::MatrixXd damped = curvature;
    damped.diagonal() += damping * curvature.diagonal();
    const Eigen::LDLT<Eigen::MatrixXd> factored(damped);
    Eigen::VectorXd step = -factored.solve(slope);
    const auto promise_of = [&](const Eigen::VectorXd& move) {
      return -(2.0 * slope.dot(move) + move.dot(curvature * move));
    };
    if (useful > 0.0 && cost - most_kept * promise_of(step) > useful * noise) break;
    const double largest = step.cwiseAbs().maxCoeff();
    if (largest > longest_step) step *= longest_step / largest;
    const double promised = promise_of(step);
    const double enough = negligible + negligible_share * std::max(0.0, cost - 2.0 * noise);
    fit.converged = promised < enough;
    if (fit.converged) break;
    Trial trial = attempt(step);
    if (trial.cost > cost - kept_well * promised && trial.residual.size() > 0) {
      // What the step left unforeseen is half its second derivative: go back by what undoes it.
      const Eigen::VectorXd bend =
          -factored.solve(jacobian_.transpose() * (trial.residual - residual - jacobian_ * step));
      if (bend.norm() < most_bend * step.norm()) {
        Trial bent = attempt(step + bend);
        if (bent.cost < trial.cost) trial = std::move(bent);
      }
    }
    const double gain = cost - trial.cost;
    const double kept = gain / promised;
    if (gain > 0.0) {
      const Eigen::VectorXd surprise = trial.residual - residual - jacobian_ * trial.step;
      jacobian_ += surprise / trial.step.squaredNorm() * trial.step.transpose();
      p_ += trial.step;
      residual = std::move(trial.residual);
      cost = trial.cost;
      // Nielsen's rule: smooth in how far the promise was kept.
      damping *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * std::min(1.0, kept) - 1.0, 3));
      raise = 2.0;
    } else {
      damping *= raise;
      raise *= 2.0;
    }
    const bool poor = kept < trusted_step;
    if (poor && !(fresh && gain <= 0.0)) {
      evaluate(p_, residual);
      differentiate();
    }
    fresh = poor;
  }
  fit.medium = medium(p_);
  fit.chi2_per_value = residual.squaredNorm() / noise;
  return fit;
}

}  // namespace kappamu::inverse
