#include "inverse/uncertainty/long_waves.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>

#include "core/numbers/conjugate_gradients.h"
#include "core/numbers/cosine_transform.h"
#include "inverse/optimise/lateral_modes.h"
#include "inverse/regulariser/roughness.h"
#include "inverse/uncertainty/posterior_hessian.h"

namespace kappamu::inverse {

namespace {

/// Upper ends of all but the last band, eigenvalues of the voxels' 3-point Laplacian: half a decade
/// each, from waves of 36 voxels.
constexpr std::array band_ends{0.03, 0.1, 0.3, 1.0, 3.0};
/// Residual of conjugate gradients against the first: errors of layers are then within 5 %.
constexpr double solved_to = 2e-2;
constexpr double mu_over_kappa = absorbers_vary * absorbers_vary;

std::size_t wave_band(double eigenvalue) {
  return static_cast<std::size_t>(std::upper_bound(band_ends.begin(), band_ends.end(), eigenvalue) -
                                  band_ends.begin());
}

/// R″ of log κ for H1, of the wave whose Laplacian has this eigenvalue.
double stiffness(const Prior& prior, double voxel_mm, double laplacian) {
  return voxel_mm / prior.thickness_mm *
         (laplacian + std::pow(voxel_mm / prior.anchor_length_mm, 2));
}

/// Depth by depth to cosines along it, of log κ's and log μ's rows.
Eigen::MatrixXd along_depth(const Eigen::MatrixXd& rows, const CosineTransform& cosines) {
  Eigen::MatrixXd waves(rows.rows(), rows.cols());
  const Eigen::Index depth = rows.rows() / 2;
  waves.topRows(depth) = cosines.forward(rows.topRows(depth));
  waves.bottomRows(depth) = cosines.forward(rows.bottomRows(depth));
  return waves;
}

}  // namespace

std::vector<double> wave_weights(const Prior& regulariser, const Vector& log_kappa,
                                 const LateralBlocks& blocks, const GridShape& shape,
                                 int depth_axis) {
  const LateralModes modes(shape, depth_axis);
  const Eigen::Index depth = modes.depth();
  const CosineTransform cosines(modes.depth());
  const Eigen::MatrixXd found =
      along_depth(modes.analyse({log_kappa, Vector(log_kappa.size(), 0.0)}), cosines);
  std::array<double, band_ends.size() + 1> roughness{};
  std::array<double, band_ends.size() + 1> directions{};
  for (int bin = 0; bin < modes.bins(); ++bin) {
    const std::vector<int>& members = modes.members(bin);
    double lateral = 0.0;
    for (const int wave : members) {
      const double across = modes.laplacian()[static_cast<std::size_t>(wave)];
      lateral += across / static_cast<double>(members.size());
      for (Eigen::Index k = 0; k < depth; ++k) {
        const double laplacian = across + laplacian_eigenvalue(static_cast<int>(k), modes.depth());
        roughness[wave_band(laplacian)] +=
            stiffness(regulariser, shape.voxel_mm, laplacian) * found(k, wave) * found(k, wave);
      }
    }
    const Eigen::MatrixXd half =
        along_depth(blocks[static_cast<std::size_t>(bin)], cosines).transpose();
    Eigen::MatrixXd hessian = along_depth(half, cosines);
    Eigen::VectorXd smoothing(2 * depth);
    for (Eigen::Index k = 0; k < depth; ++k) {
      smoothing[k] = regulariser.weight *
                     stiffness(regulariser, shape.voxel_mm,
                               lateral + laplacian_eigenvalue(static_cast<int>(k), modes.depth()));
      smoothing[depth + k] = smoothing[k] / mu_over_kappa;
    }
    hessian.diagonal() += smoothing;
    const Eigen::MatrixXd covariance =
        hessian.llt().solve(Eigen::MatrixXd::Identity(2 * depth, depth));
    for (Eigen::Index k = 0; k < depth; ++k) {
      directions[wave_band(lateral + laplacian_eigenvalue(static_cast<int>(k), modes.depth()))] +=
          static_cast<double>(members.size()) * (1.0 - covariance(k, k) * smoothing[k]);
    }
  }
  std::vector<double> weights;
  for (std::size_t band = 0; band < directions.size(); ++band) {
    weights.push_back(
        std::min(regulariser.weight, std::max(1.0, directions[band]) / roughness[band]));
  }
  return weights;
}

namespace {

/// Waves of log κ and log μ on a coarse grid, [k][wave] of the one above those of the other, and
/// fits to them.
class CoarseWaves {
 public:
  CoarseWaves(Objective& objective, const Prior& prior, const GridShape& fine, int depth_axis,
              const LongWaveOptions& options, std::uint64_t seed)
      : grid_(objective.problem().setup.shape),
        regulariser_{prior.weight, prior.thickness_mm, prior.anchor_length_mm},
        modes_(grid_, depth_axis),
        cosines_(modes_.depth()),
        hessian_(objective, regulariser_, options.probes, seed),
        steps_(options.steps),
        engine_(seed) {
    // A wave has as many half periods on both grids.
    const int a = depth_axis == 0 ? 1 : 0;
    const int b = depth_axis == 2 ? 1 : 2;
    laplacian_.resize(modes_.depth(), static_cast<Eigen::Index>(modes_.laplacian().size()));
    for (Eigen::Index wave = 0; wave < laplacian_.cols(); ++wave) {
      for (Eigen::Index k = 0; k < laplacian_.rows(); ++k) {
        laplacian_(k, wave) =
            laplacian_eigenvalue(static_cast<int>(wave) % grid_.extent(a), fine.extent(a)) +
            laplacian_eigenvalue(static_cast<int>(wave) / grid_.extent(a), fine.extent(b)) +
            laplacian_eigenvalue(static_cast<int>(k), fine.extent(depth_axis));
      }
    }
  }

  /// Eigenvalue on the fine grid of each wave [k][wave].
  const Eigen::MatrixXd& laplacian() const { return laplacian_; }
  /// Of the standard deviations `deviation` of log κ.
  Eigen::MatrixXd draw(const Eigen::MatrixXd& deviation) {
    const auto sign = [&] { return (engine_() >> 63) != 0 ? 1.0 : -1.0; };
    Eigen::MatrixXd waves(2 * deviation.rows(), deviation.cols());
    for (Eigen::Index wave = 0; wave < deviation.cols(); ++wave) {
      for (Eigen::Index k = 0; k < deviation.rows(); ++k) {
        waves(k, wave) = deviation(k, wave) * sign();
        waves(deviation.rows() + k, wave) = absorbers_vary * deviation(k, wave) * sign();
      }
    }
    return waves;
  }
  /// What a fit to exact data of `waves` would leave out, (JᵀWJ + αR″)⁻¹ αR″ of them, by layer
  /// instead of along the depth.
  Eigen::MatrixXd missed(Eigen::MatrixXd waves) {
    const Eigen::Index depth = modes_.depth();
    waves.topRows(depth) = cosines_.inverse(waves.topRows(depth)).eval();
    waves.bottomRows(depth) = cosines_.inverse(waves.bottomRows(depth)).eval();
    CoefficientPair smoothed =
        smoothing_product(grid_, regulariser_.thickness_mm, regulariser_.anchor_length_mm, {},
                          modes_.synthesise(waves));
    for (double& v : smoothed.log_kappa) v *= regulariser_.weight;
    for (double& v : smoothed.log_mu) v *= regulariser_.weight;
    const Eigen::VectorXd b = hessian_.gradient(smoothed);
    const double enough = solved_to * b.norm();
    const GradientSolution solution =
        conjugate_gradients([&](const Eigen::VectorXd& z) { return hessian_.product(z); }, b,
                            steps_, [&](const GradientStep& step) { return step.rest <= enough; });
    return modes_.analyse(hessian_.to_fields(solution.x));
  }

 private:
  GridShape grid_;
  Prior regulariser_;
  LateralModes modes_;
  CosineTransform cosines_;
  PosteriorHessian hessian_;
  int steps_;
  std::mt19937_64 engine_;
  Eigen::MatrixXd laplacian_;
};

}  // namespace

LongWaveErrors long_wave_errors(Objective& coarse, const Prior& prior, const GridShape& shape,
                                int depth_axis, const LongWaveOptions& options,
                                std::uint64_t seed) {
  const int before = coarse.solves().total();
  const GridShape& grid = coarse.problem().setup.shape;
  CoarseWaves waves(coarse, prior, shape, depth_axis, options, seed);
  const Eigen::MatrixXd& laplacian = waves.laplacian();
  const Eigen::Index depth = laplacian.rows();
  const double cells = static_cast<double>(grid.cells()) / static_cast<double>(shape.cells());
  // Of log κ. H1 leaves the mean free.
  const Eigen::MatrixXd deviation = laplacian.unaryExpr([&](double l) {
    if (l == 0.0) return 0.0;
    const double weight = std::min(prior.weight, prior.wave_weights[wave_band(l)]);
    return std::sqrt(cells * (1.0 / weight - 1.0 / prior.weight) /
                     stiffness(prior, shape.voxel_mm, l));
  });

  const auto of_layers = [&](const Eigen::VectorXd& values) {
    Vector layers;
    for (int z = 0; z < shape.extent(depth_axis); ++z) {
      const auto at = static_cast<Eigen::Index>((z + 0.5) * shape.voxel_mm / grid.voxel_mm);
      layers.push_back(values[std::min(at, depth - 1)]);
    }
    return layers;
  };
  const CosineTransform cosines(static_cast<int>(depth));
  const Eigen::VectorXd beforehand =
      cosines.inverse(Eigen::MatrixXd::Identity(depth, depth)).cwiseAbs2() *
      deviation.cwiseAbs2().rowwise().sum() / static_cast<double>(laplacian.cols());
  Eigen::VectorXd kappa = Eigen::VectorXd::Zero(depth);
  Eigen::VectorXd mu = kappa;
  Eigen::VectorXd both = kappa;
  const double share = 1.0 / static_cast<double>(options.draws * laplacian.cols());
  for (int draw = 0; draw < options.draws; ++draw) {
    const Eigen::MatrixXd missed = waves.missed(waves.draw(deviation));
    kappa += share * missed.topRows(depth).rowwise().squaredNorm();
    mu += share * missed.bottomRows(depth).rowwise().squaredNorm();
    both += share * missed.topRows(depth).cwiseProduct(missed.bottomRows(depth)).rowwise().sum();
  }
  return {{of_layers(kappa), of_layers(mu), of_layers(both)},
          {of_layers(beforehand), of_layers(mu_over_kappa * beforehand), {}},
          coarse.solves().total() - before};
}

}  // namespace kappamu::inverse
