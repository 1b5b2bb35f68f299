#include "inverse/block_model/model_layers.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/numbers/linear_algebra.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::layers;

int layer_of(const std::vector<int>& first, int slice) {
  const auto after = std::upper_bound(first.begin(), first.end(), slice);
  return static_cast<int>(after - first.begin()) - 1;
}

}  // namespace

Eigen::VectorXd unknowns(const LayeredMedium& medium) {
  const Eigen::Index layers = medium.layers();
  Eigen::VectorXd p(2 * layers);
  p << Eigen::Map<const Eigen::VectorXd>(medium.log_kappa.data(), layers),
      Eigen::Map<const Eigen::VectorXd>(medium.log_mu.data(), layers);
  return p;
}

LayeredMedium with_unknowns(LayeredMedium medium, const Eigen::VectorXd& unknowns) {
  const int layers = medium.layers();
  medium.log_kappa.assign(unknowns.begin(), unknowns.begin() + layers);
  medium.log_mu.assign(unknowns.begin() + layers, unknowns.begin() + 2 * layers);
  return medium;
}

Eigen::MatrixXd copies(const LayeredMedium& many, const LayeredMedium& few) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(2 * many.layers(), 2 * few.layers());
  for (int from = 0; from < many.layers(); ++from) {
    const int to = layer_of(few.first, many.first[static_cast<std::size_t>(from)]);
    matrix(from, to) = 1.0;
    matrix(many.layers() + from, few.layers() + to) = 1.0;
  }
  return matrix;
}

LayeredMedium merge_layers(const LayeredMedium& medium, const Eigen::MatrixXd& normal,
                           double allowance) {
  const Eigen::VectorXd p = unknowns(medium);
  const Eigen::VectorXd weighed = normal * p;
  LayeredMedium fewest = medium;
  for (;;) {
    double least = allowance;
    std::optional<LayeredMedium> best;
    for (int l = 1; l < fewest.layers(); ++l) {
      LayeredMedium fewer = fewest;
      fewer.first.erase(fewer.first.begin() + l);
      const Eigen::MatrixXd copied = copies(medium, fewer);
      const Eigen::VectorXd right = copied.transpose() * weighed;
      const Eigen::VectorXd values =
          solve_symmetric(product(copied.transpose(), product(normal, copied)), right);
      const double rise = p.dot(weighed) - values.dot(right);
      if (rise > least) continue;
      least = rise;
      best = with_unknowns(std::move(fewer), values);
    }
    if (!best) return fewest;
    fewest = std::move(*best);
  }
}

CoefficientPair to_fields(const LayeredMedium& medium, const MediumSpace& space) {
  const GridShape& shape = space.shape;
  const int axis = space.depth_axis;
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

LinearPrior layer_prior(const LayeredMedium& start) {
  const Eigen::Index layers = start.layers();
  LinearPrior prior{Eigen::MatrixXd::Zero(2 * layers - 1, 2 * layers),
                    Eigen::VectorXd::Zero(2 * layers - 1)};
  for (Eigen::Index l = 0; l + 1 < layers; ++l) {
    for (Eigen::Index half = 0; half < 2; ++half) {
      prior.rows(2 * l + half, half * layers + l) = -1.0 / defaults::expected::layer_spread;
      prior.rows(2 * l + half, half * layers + l + 1) = 1.0 / defaults::expected::layer_spread;
    }
  }
  prior.rows.bottomRows(1).setConstant(
      1.0 / (defaults::expected::absorption_spread * static_cast<double>(layers)));
  prior.value.tail(1) = prior.rows.bottomRows(1) * unknowns(start);
  return prior;
}

LayerFitter::LayerFitter(Objective& objective, const LayeredMedium& start)
    : objective_(objective),
      start_(start),
      prior_(layer_prior(start)),
      at_{unknowns(start), {}, {}} {
  const Problem& problem = objective.problem();
  for (std::size_t i = 0; i < problem.weight.size(); ++i) {
    if (problem.weight[i] > 0.0) used_.push_back(i);
  }
}

CoefficientPair LayerFitter::fields(const Eigen::VectorXd& p) const {
  return to_fields(medium(p), objective_.space());
}

Eigen::VectorXd LayerFitter::residual(const Eigen::VectorXd& p) {
  const Problem& problem = objective_.problem();
  if (!std::isfinite(objective_.value(fields(p)))) return {};
  const std::vector<double> prediction = objective_.prediction();
  Eigen::VectorXd r(static_cast<Eigen::Index>(used_.size()));
  for (std::size_t k = 0; k < used_.size(); ++k) {
    const std::size_t i = used_[k];
    r[static_cast<Eigen::Index>(k)] =
        std::sqrt(problem.weight[i]) * (prediction[i] - problem.data[i]);
  }
  return r;
}

Eigen::MatrixXd LayerFitter::jacobian(const Eigen::VectorXd& p) {
  objective_.value(fields(p));
  Eigen::MatrixXd result(static_cast<Eigen::Index>(used_.size()), p.size());
  for (Eigen::Index k = 0; k < p.size(); ++k) {
    const std::vector<double> change =
        objective_.jacobian(fields(Eigen::VectorXd::Unit(p.size(), k)));
    for (std::size_t i = 0; i < used_.size(); ++i) {
      result(static_cast<Eigen::Index>(i), k) = change[used_[i]];
    }
  }
  return result;
}

const Eigen::VectorXd& LayerFitter::evaluate() {
  at_.residual = residual(at_.p);
  if (at_.residual.size() == 0) throw InputError("the diffusion solver fails at these layers");
  return at_.residual;
}

Eigen::MatrixXd LayerFitter::normal() const {
  return at_.jacobian.transpose() * at_.jacobian + prior_.rows.transpose() * prior_.rows;
}

Eigen::MatrixXd LayerFitter::slope_covariance(const ErrorCovariance& errors) const {
  return errors.between(at_.jacobian, used_) + prior_.rows.transpose() * prior_.rows;
}

std::vector<double> LayerFitter::residual_without_common(const ErrorCovariance& errors) {
  const Eigen::VectorXd left = errors.without_common(evaluate(), at_.jacobian, used_);
  std::vector<double> all(objective_.problem().data.size(), 0.0);
  for (std::size_t k = 0; k < used_.size(); ++k) {
    all[used_[k]] = left[static_cast<Eigen::Index>(k)];
  }
  return all;
}

Eigen::MatrixXd LayerFitter::covariance() {
  evaluate();
  at_.jacobian = jacobian(at_.p);
  return solve_symmetric(normal(), Eigen::MatrixXd::Identity(at_.p.size(), at_.p.size()));
}

Eigen::MatrixXd LayerFitter::covariance(const ErrorCovariance& errors) {
  const Eigen::MatrixXd inverse = covariance();
  return inverse * slope_covariance(errors) * inverse;
}

LayeredFit LayerFitter::descend(double useful) {
  evaluate();
  const auto noise = static_cast<double>(used_.size());
  const auto next = [useful, noise](const PlannedStep& planned) {
    if (useful > 0.0 && planned.cost - most_kept * planned.hoped > useful * noise) {
      return Continue::give_up;
    }
    const double enough = negligible + negligible_share * std::max(0.0, planned.cost - 2.0 * noise);
    return planned.promised < enough ? Continue::converged : Continue::yes;
  };
  const LevenbergMarquardtReport report =
      levenberg_marquardt(*this, prior_, at_, {.most_bend = most_bend}, next);
  return {medium(at_.p), at_.residual.squaredNorm() / noise, report.steps, report.converged};
}

}  // namespace kappamu::inverse
