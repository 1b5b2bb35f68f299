#include "inverse/uncertainty/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/numbers/median.h"
#include "core/shown_text.h"
#include "inverse/optimise/lateral_hessian.h"
#include "inverse/regulariser/roughness.h"
#include "inverse/uncertainty/local_information.h"
#include "inverse/uncertainty/point_spread.h"

namespace kappamu::inverse {

namespace {

Basis metric(Coordinates coordinates, const Prior& prior, const MediumSpace& space,
             const LateralBlocks& blocks) {
  return {space, {coordinates, prior.anchor_length_mm, prior.weight}, blocks};
}

/// The prior keeps the metric definite.
constexpr double no_ridge = 0.0;

}  // namespace

LateralBlocks prior_blocks(std::span<const CoefficientPair> rows, const MediumSpace& space) {
  return lateral_blocks(rows, space, no_ridge);
}

Basis posterior_metric(const Prior& prior, const MediumSpace& space, const LateralBlocks& blocks) {
  return metric(Coordinates::informed, prior, space, blocks);
}

Basis prior_metric(const Prior& prior, const MediumSpace& space) {
  return metric(Coordinates::smooth, prior, space, {});
}

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
    layers.push_back({.depth_mm = (k + 0.5) * shape.voxel_mm,
                      .log_kappa_std = middle(found.log_kappa_std),
                      .log_mu_std = middle(found.log_mu_std),
                      .kappa_resolution = middle(found.kappa_resolution),
                      .mu_resolution = middle(found.mu_resolution),
                      .correlation = middle(found.correlation)});
  }
  return layers;
}

CoefficientPair hessian_product(Objective& objective, const Prior& prior,
                                const CoefficientPair& v) {
  std::vector<double> seen = objective.jacobian(v);
  objective.weigh(seen);
  CoefficientPair product = objective.jacobian_transpose(seen);
  const CoefficientPair smoothness =
      smoothing_product(objective.space(), prior.anchor_length_mm, {}, v);
  for (std::size_t i = 0; i < product.log_mu.size(); ++i) {
    product.log_kappa[i] += prior.weight * smoothness.log_kappa[i];
    product.log_mu[i] += prior.weight * smoothness.log_mu[i];
  }
  return product;
}

Uncertainty estimate_uncertainty(const Prior& prior, const MediumSpace& space, Face seen_face,
                                 const LateralBlocks& blocks, const CoefficientPair& sensitivity,
                                 const SharedDeviation& shared) {
  const GridShape& shape = space.shape;
  const Basis before = prior_metric(prior, space);
  const Basis metric = posterior_metric(prior, space, blocks);
  const FieldCovariance even = metric.covariance();
  const CoefficientPair beforehand = before.covariance().variance;
  const CoefficientPair posterior = distributed(even.variance, beforehand, sensitivity, space);
  Uncertainty found{Volume<float>(shape), Volume<float>(shape), Volume<float>(shape),
                    Volume<float>(shape), Volume<float>(shape), {}};
  const std::size_t stride = space.depth_axis == 0   ? 1
                             : space.depth_axis == 1 ? shape.index(0, 1, 0)
                                                     : shape.index(0, 0, 1);
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    const auto add = [&](double variance, double prior_value, double beside,
                         Volume<float>& deviation, Volume<float>& resolution) {
      deviation[i] = static_cast<float>(std::hypot(std::sqrt(variance), beside));
      resolution[i] = static_cast<float>(std::clamp(1.0 - variance / prior_value, 0.0, 1.0));
    };
    const std::size_t slice = i / stride % static_cast<std::size_t>(space.depth());
    add(posterior.log_kappa[i], beforehand.log_kappa[i], shared.kappa_at(slice),
        found.log_kappa_std, found.kappa_resolution);
    add(posterior.log_mu[i], beforehand.log_mu[i], shared.mu_at(slice), found.log_mu_std,
        found.mu_resolution);
    found.correlation[i] = static_cast<float>(
        even.between[i] / std::sqrt(even.variance.log_kappa[i] * even.variance.log_mu[i]));
  }
  found.report.layers = layers_below(found, seen_face);
  const PointSpread spread = point_spread(before, metric, space);
  const std::size_t depth = found.report.layers.size();
  for (std::size_t k = 0; k < depth; ++k) {
    const std::size_t slice = is_plus(seen_face) ? depth - 1 - k : k;
    found.report.layers[k].kappa_fwhm_mm = spread.kappa_mm[slice];
    found.report.layers[k].mu_fwhm_mm = spread.mu_mm[slice];
  }
  found.report.sentence =
      in_words(found.report.layers) +
      formatted(
          " Deviations include %.2g %% of κ and %.2g %% of μ, by which fits of such structure miss "
          "known truths whatever the noise: steady light determines one against the other weakly, "
          "and unresolved structure changes it.",
          100.0 * shared.log_kappa, 100.0 * shared.log_mu);
  found.report.shared = shared;
  return found;
}

}  // namespace kappamu::inverse
