#include "inverse/uncertainty/uncertainty.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <random>
#include <utility>

#include "core/error.h"
#include "core/numbers/median.h"
#include "inverse/optimise/lateral_hessian.h"
#include "inverse/regulariser/roughness.h"
#include "inverse/uncertainty/spectral_prior.h"

namespace kappamu::inverse {

namespace {

Vector signs(std::mt19937_64& engine, std::size_t count) {
  Vector values(count);
  for (double& s : values) s = (engine() >> 63) != 0 ? 1.0 : -1.0;
  return values;
}

/// The prior keeps the metric definite.
constexpr double no_ridge = 0.0;

BasisOptions metric(const Prior& prior, int axis) {
  return {Coordinates::informed, axis, prior.thickness_mm, prior.anchor_length_mm, prior.weight};
}

/// 2 R of the Gaussian that stands for Huber-TV, of log κ alone.
double kappa_roughness(const GridShape& shape, const Prior& prior, const Vector& log_kappa) {
  const Vector product = smoothing_product(shape, prior.thickness_mm, prior.anchor_length_mm,
                                           prior.diffusivity, {log_kappa, Vector(log_kappa.size())})
                             .log_kappa;
  return std::inner_product(log_kappa.begin(), log_kappa.end(), product.begin(), 0.0);
}

/// What the samples of the posterior are made of.
struct Posterior {
  Basis basis;
  FieldOperator prior_product;  ///< α R″ v
  CoefficientPair prior_variance;
  double least_weight;
};

Posterior of_h1(const GridShape& shape, int axis, const Prior& prior,
                const std::optional<Vector>& log_kappa, LateralBlocks blocks) {
  SpectralPrior spectral(shape, axis, prior);
  if (log_kappa) spectral.bear_out(*log_kappa, blocks);
  const LateralBlocks precision = spectral.precision();
  for (std::size_t bin = 0; bin < blocks.size(); ++bin) blocks[bin] += precision[bin];
  BasisOptions blocks_alone = metric(prior, axis);
  blocks_alone.weight = 0.0;
  return {Basis(shape, blocks_alone, blocks),
          [spectral](const CoefficientPair& v) { return spectral.product(v); }, spectral.variance(),
          spectral.least_weight()};
}

/// Its edges couple all frequencies: one weight.
Posterior of_huber_tv(const GridShape& shape, int axis, Prior prior,
                      const std::optional<Vector>& log_kappa, const LateralBlocks& blocks,
                      const UncertaintyOptions& options, std::uint64_t seed) {
  if (log_kappa) {
    const double directions = Basis(shape, metric(prior, axis), blocks).determined(blocks).kappa;
    prior.weight = std::min(prior.weight,
                            std::max(1.0, directions) / kappa_roughness(shape, prior, *log_kappa));
  }
  return {Basis(shape, metric(prior, axis), blocks),
          [=](const CoefficientPair& v) {
            CoefficientPair product = smoothing_product(
                shape, prior.thickness_mm, prior.anchor_length_mm, prior.diffusivity, v);
            for (double& x : product.log_kappa) x *= prior.weight;
            for (double& x : product.log_mu) x *= prior.weight;
            return product;
          },
          prior_variance(shape, axis, prior, options, seed), prior.weight};
}

}  // namespace

std::vector<LayerUncertainty> layers_below(const Uncertainty& found, Face seen_face) {
  const GridShape& shape = found.log_mu_std.shape();
  const FaceShape face = face_shape(shape, seen_face);
  std::vector<LayerUncertainty> layers;
  for (int k = 0; k < shape.extent(axis_of(seen_face)); ++k) {
    const auto middle = [&](const Volume<float>& volume) {
      std::vector<float> layer;
      for (int v = 0; v < face.nv; ++v) {
        for (int u = 0; u < face.nu; ++u) {
          layer.push_back(volume[face_cell(shape, seen_face, u, v, k)]);
        }
      }
      return upper_median(std::move(layer));
    };
    layers.push_back({(k + 0.5) * shape.voxel_mm, middle(found.log_kappa_std),
                      middle(found.log_mu_std), middle(found.kappa_resolution),
                      middle(found.mu_resolution), middle(found.correlation)});
  }
  return layers;
}

CoefficientPair prior_variance(const GridShape& shape, int depth_axis, const Prior& prior,
                               const UncertaintyOptions& options, std::uint64_t seed) {
  if (prior.diffusivity.log_kappa.empty())
    return SpectralPrior(shape, depth_axis, prior).variance();
  const Basis basis(
      shape, {Coordinates::smooth, depth_axis, prior.thickness_mm, prior.anchor_length_mm, 1.0},
      {});
  const auto precision = [&](const CoefficientPair& v) {
    return smoothing_product(shape, prior.thickness_mm, prior.anchor_length_mm, prior.diffusivity,
                             v);
  };
  InverseDiagonal diagonal(precision, shape, depth_axis, basis, options.steps);
  std::mt19937_64 engine(seed);
  for (int k = 0; k < options.samples; ++k) diagonal.add(signs(engine, 2 * shape.cells()));
  CoefficientPair variance = diagonal.result(options.pooling).variance;
  for (double& v : variance.log_kappa) v /= prior.weight;
  for (double& v : variance.log_mu) v /= prior.weight;
  return variance;
}

CoefficientPair hessian_product(Objective& objective, const Prior& prior,
                                const CoefficientPair& v) {
  CoefficientPair product = objective.jacobian_transpose(objective.jacobian(v));
  const CoefficientPair smoothness =
      smoothing_product(objective.problem().setup.shape, prior.thickness_mm, prior.anchor_length_mm,
                        prior.diffusivity, v);
  for (std::size_t i = 0; i < product.log_mu.size(); ++i) {
    product.log_kappa[i] += prior.weight * smoothness.log_kappa[i];
    product.log_mu[i] += prior.weight * smoothness.log_mu[i];
  }
  return product;
}

Uncertainty estimate_uncertainty(Objective& objective, Prior prior,
                                 const std::optional<Vector>& log_kappa,
                                 const UncertaintyOptions& options, std::uint64_t seed) {
  check(options.samples >= 1 && options.steps >= 1 && options.probes >= 1 && options.pooling >= 0.0,
        "uncertainty: options are out of bounds");
  const Problem& problem = objective.problem();
  const GridShape& shape = problem.setup.shape;
  const int axis = axis_of(problem.setup.lit_face);
  const auto solves = [&] { return objective.solves().adjoint + objective.solves().tangent; };
  const int before = solves();
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  LateralBlocks blocks = estimate_lateral_blocks(objective, axis, options.probes, seed, no_ridge);
  const Posterior posterior =
      prior.diffusivity.log_kappa.empty()
          ? of_h1(shape, axis, prior, log_kappa, std::move(blocks))
          : of_huber_tv(shape, axis, prior, log_kappa, blocks, options, seed + 2);
  InverseDiagonal diagonal(
      [&](const CoefficientPair& v) {
        CoefficientPair product = objective.jacobian_transpose(objective.jacobian(v));
        const CoefficientPair smoothness = posterior.prior_product(v);
        for (std::size_t i = 0; i < product.log_mu.size(); ++i) {
          product.log_kappa[i] += smoothness.log_kappa[i];
          product.log_mu[i] += smoothness.log_mu[i];
        }
        return product;
      },
      shape, axis, posterior.basis, options.steps);
  std::mt19937_64 engine(seed + 1);
  for (int k = 0; k < options.samples; ++k) diagonal.add(signs(engine, 2 * shape.cells()));
  const FieldCovariance covariance = diagonal.result(options.pooling);

  Uncertainty found{Volume<float>(shape), Volume<float>(shape), Volume<float>(shape),
                    Volume<float>(shape), Volume<float>(shape), {}};
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    // Data only ever add to what is known: an estimate above the prior is the estimate's error.
    const auto add = [&](double variance, double prior_value, Volume<float>& deviation,
                         Volume<float>& resolution) {
      const double share = std::clamp(1.0 - variance / prior_value, 0.0, 1.0);
      deviation[i] = static_cast<float>(std::sqrt(std::min(variance, prior_value)));
      resolution[i] = static_cast<float>(share);
    };
    const double kappa = covariance.variance.log_kappa[i];
    const double mu = covariance.variance.log_mu[i];
    add(kappa, posterior.prior_variance.log_kappa[i], found.log_kappa_std, found.kappa_resolution);
    add(mu, posterior.prior_variance.log_mu[i], found.log_mu_std, found.mu_resolution);
    found.correlation[i] = static_cast<float>(covariance.between[i] / std::sqrt(kappa * mu));
  }
  UncertaintyReport& report = found.report;
  report.layers = layers_below(found, problem.seen_face);
  report.sentence = in_words(report.layers);
  report.solves = solves() - before;
  report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  report.unfinished = diagonal.unfinished();
  report.prior_weights = {posterior.least_weight, prior.weight};
  return found;
}

}  // namespace kappamu::inverse
