#include "inverse/uncertainty/spectral_prior.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "inverse/regulariser/roughness.h"
#include "inverse/uncertainty/uncertainty.h"

namespace kappamu::inverse {

namespace {

/// Eigenvalue of the 3-point Neumann Laplacian along the depth.
double depth_laplacian_eigenvalue(Eigen::Index k, Eigen::Index n) {
  return 2.0 - 2.0 * std::cos(std::numbers::pi * static_cast<double>(k) / static_cast<double>(n));
}

Eigen::MatrixXd orthonormal_cosines(Eigen::Index n) {
  Eigen::MatrixXd cosines(n, n);
  const auto count = static_cast<double>(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    for (Eigen::Index i = 0; i < n; ++i) {
      cosines(k, i) = std::sqrt((k == 0 ? 1.0 : 2.0) / count) *
                      std::cos(std::numbers::pi * static_cast<double>(k) *
                               (static_cast<double>(i) + 0.5) / count);
    }
  }
  return cosines;
}

constexpr double mu_over_kappa = 1.0 / (absorbers_vary * absorbers_vary);

}  // namespace

SpectralPrior::SpectralPrior(const GridShape& shape, int depth_axis, const Prior& prior)
    : modes_(shape, depth_axis),
      cosines_(orthonormal_cosines(shape.extent(depth_axis))),
      scale_(shape.voxel_mm / prior.thickness_mm),
      pull_(std::pow(shape.voxel_mm / prior.anchor_length_mm, 2)),
      longest_(std::max({shape.nx, shape.ny, shape.nz})) {
  // The highest frequency has an eigenvalue of 4 along each axis.
  weights_.assign(static_cast<std::size_t>(std::lround(longest_ * std::sqrt(3.0))) + 1,
                  prior.weight);
}

double SpectralPrior::square(int wave, Eigen::Index along_depth) const {
  return scale_ * (modes_.laplacian()[static_cast<std::size_t>(wave)] +
                   depth_laplacian_eigenvalue(along_depth, cosines_.rows()) + pull_);
}

std::size_t SpectralPrior::band(int wave, Eigen::Index along_depth) const {
  const double eigenvalue = modes_.laplacian()[static_cast<std::size_t>(wave)] +
                            depth_laplacian_eigenvalue(along_depth, cosines_.rows());
  const double frequency = longest_ * std::sqrt(eigenvalue) / std::numbers::pi;
  return std::min(weights_.size() - 1, static_cast<std::size_t>(std::lround(frequency)));
}

Eigen::MatrixXd SpectralPrior::spectrum() const {
  const Eigen::Index depth = cosines_.rows();
  Eigen::MatrixXd values(2 * depth, static_cast<Eigen::Index>(modes_.laplacian().size()));
  for (Eigen::Index wave = 0; wave < values.cols(); ++wave) {
    for (Eigen::Index k = 0; k < depth; ++k) {
      const auto w = static_cast<int>(wave);
      values(k, wave) = weight(w, k) * square(w, k);
      values(depth + k, wave) = mu_over_kappa * values(k, wave);
    }
  }
  return values;
}

void SpectralPrior::bear_out(const Vector& log_kappa, const LateralBlocks& blocks) {
  const Eigen::Index depth = cosines_.rows();
  const Eigen::MatrixXd found =
      cosines_ * modes_.analyse({log_kappa, Vector(log_kappa.size(), 0.0)}).topRows(depth);
  const LateralBlocks beforehand = precision();
  std::vector<double> directions(weights_.size(), 0.0);  // γ
  std::vector<double> roughness(weights_.size(), 0.0);   // 2 R
  for (int bin = 0; bin < modes_.bins(); ++bin) {
    const Eigen::MatrixXd& data = blocks[static_cast<std::size_t>(bin)];
    const Eigen::MatrixXd share =
        (data + beforehand[static_cast<std::size_t>(bin)]).llt().solve(data);
    const Eigen::VectorXd by_frequency =
        (cosines_ * share.topLeftCorner(depth, depth) * cosines_.transpose()).diagonal();
    for (const int wave : modes_.members(bin)) {
      for (Eigen::Index k = 0; k < depth; ++k) {
        const std::size_t b = band(wave, k);
        directions[b] += by_frequency[k];
        roughness[b] += square(wave, k) * found(k, wave) * found(k, wave);
      }
    }
  }
  const auto expects = [](double determined, double rough) {
    return std::max(1.0, determined) / rough;
  };
  const double overall = expects(std::accumulate(directions.begin(), directions.end(), 0.0),
                                 std::accumulate(roughness.begin(), roughness.end(), 0.0));
  for (std::size_t b = 0; b < weights_.size(); ++b) {
    weights_[b] = std::min({weights_[b], overall, expects(directions[b], roughness[b])});
  }
}

double SpectralPrior::least_weight() const {
  return *std::min_element(weights_.begin(), weights_.end());
}

CoefficientPair SpectralPrior::product(const CoefficientPair& v) const {
  const Eigen::Index depth = cosines_.rows();
  Eigen::MatrixXd coefficients = modes_.analyse(v);
  const Eigen::MatrixXd values = spectrum();
  for (const Eigen::Index first : {Eigen::Index{0}, depth}) {
    const Eigen::MatrixXd waves = (cosines_ * coefficients.middleRows(first, depth))
                                      .cwiseProduct(values.middleRows(first, depth));
    coefficients.middleRows(first, depth) = cosines_.transpose() * waves;
  }
  return modes_.synthesise(coefficients);
}

LateralBlocks SpectralPrior::precision() const {
  const Eigen::Index depth = cosines_.rows();
  const Eigen::MatrixXd values = spectrum();
  LateralBlocks blocks;
  for (int bin = 0; bin < modes_.bins(); ++bin) {
    const Eigen::VectorXd mean = values(Eigen::all, modes_.members(bin)).rowwise().mean();
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(2 * depth, 2 * depth);
    for (const Eigen::Index first : {Eigen::Index{0}, depth}) {
      block.block(first, first, depth, depth) =
          cosines_.transpose() * mean.segment(first, depth).asDiagonal() * cosines_;
    }
    blocks.push_back(std::move(block));
  }
  return blocks;
}

CoefficientPair SpectralPrior::variance() const {
  const Eigen::Index depth = cosines_.rows();
  const Eigen::MatrixXd squares = cosines_.cwiseAbs2().transpose();
  const Eigen::MatrixXd inverse = spectrum().cwiseInverse();
  Eigen::MatrixXd by_depth(inverse.rows(), inverse.cols());
  by_depth.topRows(depth) = squares * inverse.topRows(depth);
  by_depth.bottomRows(depth) = squares * inverse.bottomRows(depth);
  return modes_.spread(by_depth);
}

}  // namespace kappamu::inverse
