#include "inverse/uncertainty.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>

#include "core/error.h"
#include "core/median.h"
#include "inverse/lateral_hessian.h"
#include "inverse/roughness.h"

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

double laplacian_eigenvalue(int k, int n) {
  return 2.0 - 2.0 * std::cos(std::numbers::pi * k / n);
}

Vector signs(std::mt19937_64& engine, std::size_t count) {
  Vector values(count);
  for (double& s : values) s = (engine() >> 63) != 0 ? 1.0 : -1.0;
  return values;
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

void validate(const UncertaintyOptions& options) {
  const auto fail = [](const std::string& what) { throw InputError("uncertainty: " + what); };
  if (options.samples < 0) fail("samples is negative; 0 asks for none");
  if (options.steps < 1) fail("steps must be at least 1");
  if (options.probes < 1) fail("probes must be at least 1");
  if (!(options.pooling >= 0.0)) fail("pooling must not be negative");
}

int solves_needed(const UncertaintyOptions& options) {
  return options.samples == 0 ? 0 : options.probes + 2 * options.steps * options.samples;
}

double memory_needed_mb(const UncertaintyOptions& options, const GridShape& shape, int batch) {
  // Vectors of one sample in floats; sums, metric and work in doubles; φ and the right-hand side of
  // a tangent solve in doubles.
  constexpr double pairs_of_volumes = 12.0;
  const double per_voxel = 2.0 * (4.0 * options.steps + 8.0 * pairs_of_volumes) + 2.0 * 8.0 * batch;
  return options.samples == 0 ? 0.0 : per_voxel * static_cast<double>(shape.cells()) / 1048576.0;
}

CoefficientPair prior_variance(const GridShape& shape, const Prior& prior) {
  const double scale = prior.weight * shape.voxel_mm / prior.thickness_mm;
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
  return {variance, variance};
}

CoefficientPair hessian_product(Objective& objective, const Prior& prior,
                                const CoefficientPair& v) {
  CoefficientPair product = objective.jacobian_transpose(objective.jacobian(v));
  // R is quadratic: its gradient with the anchor at zero is R″ v.
  const CoefficientPair smoothness = roughness(objective.problem().setup.shape, prior.thickness_mm,
                                               v, Anchor{0.0, 0.0, prior.anchor_length_mm})
                                         .gradient;
  for (std::size_t i = 0; i < product.log_mu.size(); ++i) {
    product.log_kappa[i] += prior.weight * smoothness.log_kappa[i];
    product.log_mu[i] += prior.weight * smoothness.log_mu[i];
  }
  return product;
}

Uncertainty estimate_uncertainty(Objective& objective, const Prior& prior,
                                 const UncertaintyOptions& options, std::uint64_t seed) {
  validate(options);
  const Problem& problem = objective.problem();
  const GridShape& shape = problem.setup.shape;
  const int axis = axis_of(problem.setup.lit_face);
  const auto solves = [&] { return objective.solves().adjoint + objective.solves().tangent; };
  const int before = solves();
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  // The fit's own metric, with the prior's own length.
  const Basis basis(
      shape,
      {Coordinates::informed, axis, prior.thickness_mm, prior.anchor_length_mm, prior.weight},
      estimate_lateral_blocks(objective, axis, options.probes, seed));
  InverseDiagonal diagonal(
      [&](const CoefficientPair& v) { return hessian_product(objective, prior, v); }, shape, axis,
      basis, options.steps);
  std::mt19937_64 engine(seed + 1);
  for (int k = 0; k < options.samples; ++k) diagonal.add(signs(engine, 2 * shape.cells()));
  const FieldCovariance posterior = diagonal.result(options.pooling);
  const CoefficientPair beforehand = prior_variance(shape, prior);

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
  report.solves = solves() - before;
  report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  report.unfinished = diagonal.unfinished();
  return found;
}

}  // namespace kappamu::inverse
