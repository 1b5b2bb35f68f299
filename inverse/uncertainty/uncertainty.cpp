#include "inverse/uncertainty/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <random>
#include <utility>

#include "core/error.h"
#include "core/numbers/median.h"
#include "core/processor_time.h"
#include "inverse/optimise/lateral_hessian.h"
#include "inverse/regulariser/roughness.h"

namespace kappamu::inverse {

namespace {

/// Squares of the orthonormal cosines (DCT-II), [frequency][voxel].
Eigen::MatrixXd squared_cosines(int n) {
  Eigen::MatrixXd squares(n, n);
  for (int k = 0; k < n; ++k) {
    for (int i = 0; i < n; ++i) {
      const double cosine = std::cos(std::numbers::pi * k * (i + 0.5) / n);
      squares(k, i) = (k == 0 ? 1.0 : 2.0) / n * cosine * cosine;
    }
  }
  return squares;
}

Vector signs(std::mt19937_64& engine, std::size_t count) {
  Vector values(count);
  for (double& s : values) s = (engine() >> 63) != 0 ? 1.0 : -1.0;
  return values;
}

/// Variances at weight one, at the prior's own.
CoefficientPair weighed(CoefficientPair variance, const Prior& prior) {
  for (double& v : variance.log_kappa) v /= prior.weight;
  for (double& v : variance.log_mu) v /= prior.weight;
  return variance;
}

/// Adds to each voxel what its layer along `axis` has.
void add_layers(Vector& values, const Vector& by_layer, const GridShape& shape, int axis) {
  if (by_layer.empty()) return;
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        values[shape.index(x, y, z)] += by_layer[static_cast<std::size_t>(axis == 0   ? x
                                                                          : axis == 1 ? y
                                                                                      : z)];
      }
    }
  }
}

/// The prior keeps the metric definite.
constexpr double no_ridge = 0.0;

}  // namespace

LateralBlocks prior_blocks(std::span<const CoefficientPair> rows, const GridShape& shape,
                           int depth_axis) {
  return lateral_blocks(rows, shape, depth_axis, no_ridge);
}

Basis posterior_metric(const Prior& prior, const GridShape& shape, int depth_axis,
                       const LateralBlocks& blocks) {
  return {
      shape,
      {Coordinates::informed, depth_axis, prior.thickness_mm, prior.anchor_length_mm, prior.weight},
      blocks};
}

/// Gaussian fields that the data determine in γ directions have 2 α R = γ in expectation at the
/// minimum (MacKay 1992). The fit's α is the largest that the noise allows: where the data made
/// log κ rougher than it expects, the α that expects it takes its place. Never a larger one, and at
/// least one direction is determined: fewer say nothing of roughness. Of log μ the data often
/// determine a handful, all of them smooth, which says as little.
Prior empirical_prior(Prior regulariser, double roughness, const LateralBlocks& blocks,
                      const GridShape& shape, int depth_axis) {
  const Basis basis = posterior_metric(regulariser, shape, depth_axis, blocks);
  const double directions = std::max(1.0, basis.determined(blocks).kappa);
  regulariser.weight = std::min(regulariser.weight, directions / roughness);
  return regulariser;
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
    layers.push_back({(k + 0.5) * shape.voxel_mm, middle(found.log_kappa_std),
                      middle(found.log_mu_std), middle(found.kappa_resolution),
                      middle(found.mu_resolution), middle(found.correlation)});
  }
  return layers;
}

CoefficientPair prior_variance(const GridShape& shape, const Prior& prior) {
  const double scale = shape.voxel_mm / prior.thickness_mm;
  const double pull = std::pow(shape.voxel_mm / prior.anchor_length_mm, 2);
  const Eigen::MatrixXd along_x = squared_cosines(shape.nx);
  const Eigen::MatrixXd along_y = squared_cosines(shape.ny);
  const Eigen::MatrixXd along_z = squared_cosines(shape.nz);
  Vector variance(shape.cells(), 0.0);
  for (int c = 0; c < shape.nz; ++c) {
    Eigen::MatrixXd spectrum(shape.nx, shape.ny);
    for (int b = 0; b < shape.ny; ++b) {
      for (int a = 0; a < shape.nx; ++a) {
        spectrum(a, b) =
            1.0 / (scale * (laplacian_eigenvalue(a, shape.nx) + laplacian_eigenvalue(b, shape.ny) +
                            laplacian_eigenvalue(c, shape.nz) + pull));
      }
    }
    const Eigen::MatrixXd plane = along_x.transpose() * spectrum * along_y;
    for (int z = 0; z < shape.nz; ++z) {
      for (int y = 0; y < shape.ny; ++y) {
        for (int x = 0; x < shape.nx; ++x) {
          variance[shape.index(x, y, z)] += along_z(c, z) * plane(x, y);
        }
      }
    }
  }
  CoefficientPair both{variance, std::move(variance)};
  for (double& v : both.log_mu) v *= absorbers_vary * absorbers_vary;
  return weighed(std::move(both), prior);
}

CoefficientPair hessian_product(Objective& objective, const Prior& prior,
                                const CoefficientPair& v) {
  std::vector<double> seen = objective.jacobian(v);
  objective.weigh(seen);
  CoefficientPair product = objective.jacobian_transpose(seen);
  const CoefficientPair smoothness = smoothing_product(
      objective.problem().setup.shape, prior.thickness_mm, prior.anchor_length_mm, {}, v);
  for (std::size_t i = 0; i < product.log_mu.size(); ++i) {
    product.log_kappa[i] += prior.weight * smoothness.log_kappa[i];
    product.log_mu[i] += prior.weight * smoothness.log_mu[i];
  }
  return product;
}

double kappa_roughness(const GridShape& shape, const Prior& prior, CoefficientPair fields,
                       const Anchor& anchor) {
  Vector& u = fields.log_kappa;
  for (double& value : u) value -= anchor.log_kappa;
  const Vector product =
      smoothing_product(shape, prior.thickness_mm, prior.anchor_length_mm, {}, fields).log_kappa;
  return std::inner_product(u.begin(), u.end(), product.begin(), 0.0);
}

Uncertainty estimate_uncertainty(Objective& objective, const Prior& prior,
                                 const UncertaintyOptions& options, std::uint64_t seed,
                                 LateralBlocks blocks, const LongWaveErrors& long_waves) {
  check(options.samples >= 1 && options.steps >= 1 && options.probes >= 1 && options.pooling >= 0.0,
        "uncertainty: options are out of bounds");
  const Problem& problem = objective.problem();
  const GridShape& shape = problem.setup.shape;
  const int axis = axis_of(problem.setup.lit_face);
  const auto solves = [&] { return objective.solves().adjoint + objective.solves().tangent; };
  const int before = solves();
  const double iterations_before = objective.solves().voxel_iterations;
  const Stopwatch watch;
  if (blocks.empty()) {
    blocks = prior_blocks(random_rows(objective, options.probes, seed), shape, axis);
  }
  const Basis basis = posterior_metric(prior, shape, axis, blocks);
  InverseDiagonal diagonal(
      [&](const CoefficientPair& v) { return hessian_product(objective, prior, v); }, shape, axis,
      basis, options.steps);
  std::mt19937_64 engine(seed + 1);
  for (int k = 0; k < options.samples; ++k) diagonal.add(signs(engine, 2 * shape.cells()));
  FieldCovariance posterior = diagonal.result(options.pooling);
  CoefficientPair beforehand = prior_variance(shape, prior);
  add_layers(posterior.variance.log_kappa, long_waves.error.log_kappa, shape, axis);
  add_layers(posterior.variance.log_mu, long_waves.error.log_mu, shape, axis);
  add_layers(posterior.between, long_waves.error.between, shape, axis);
  add_layers(beforehand.log_kappa, long_waves.beforehand.log_kappa, shape, axis);
  add_layers(beforehand.log_mu, long_waves.beforehand.log_mu, shape, axis);

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
    const double kappa = posterior.variance.log_kappa[i];
    const double mu = posterior.variance.log_mu[i];
    add(kappa, beforehand.log_kappa[i], found.log_kappa_std, found.kappa_resolution);
    add(mu, beforehand.log_mu[i], found.log_mu_std, found.mu_resolution);
    found.correlation[i] = static_cast<float>(posterior.between[i] / std::sqrt(kappa * mu));
  }
  UncertaintyReport& report = found.report;
  report.layers = layers_below(found, problem.seen_face);
  report.sentence = in_words(report.layers);
  report.solves = solves() - before + long_waves.solves;
  report.voxel_iterations = objective.solves().voxel_iterations - iterations_before;
  report.seconds = watch.seconds();
  report.unfinished = diagonal.unfinished();
  report.prior = prior;
  return found;
}

}  // namespace kappamu::inverse
