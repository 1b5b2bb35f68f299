#include "inverse/optimise/basis.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "inverse/regulariser/roughness.h"

namespace kappamu::inverse {

namespace {

Vector joined(const CoefficientPair& fields) {
  Vector z = fields.log_kappa;
  z.insert(z.end(), fields.log_mu.begin(), fields.log_mu.end());
  return z;
}

CoefficientPair parted(const Vector& z) {
  const auto half = static_cast<std::ptrdiff_t>(z.size() / 2);
  return {Vector(z.begin(), z.begin() + half), Vector(z.begin() + half, z.end())};
}

/// The 3-point Neumann Laplacian along the depth, for κ and for μ.
Eigen::MatrixXd depth_laplacian(Eigen::Index depth) {
  Eigen::MatrixXd laplacian = Eigen::MatrixXd::Zero(2 * depth, 2 * depth);
  for (Eigen::Index d = 0; d + 1 < depth; ++d) {
    for (const Eigen::Index i : {d, depth + d}) {
      laplacian(i, i) += 1.0;
      laplacian(i + 1, i + 1) += 1.0;
      laplacian(i, i + 1) -= 1.0;
      laplacian(i + 1, i) -= 1.0;
    }
  }
  return laplacian;
}

}  // namespace

Basis::Basis(const MediumSpace& space, const BasisOptions& options, const LateralBlocks& blocks)
    : Basis(options.coordinates == Coordinates::voxels ? nullptr
                                                       : std::make_shared<LateralModes>(space),
            space, options, blocks) {}

Basis::Basis(std::shared_ptr<const LateralWaves> waves, const MediumSpace& space,
             const BasisOptions& options, const LateralBlocks& blocks)
    : cells_(space.cells()), waves_(std::move(waves)) {
  if (!waves_) return;
  const bool informed = options.coordinates == Coordinates::informed;
  check(!informed || static_cast<int>(blocks.size()) == waves_->bins(),
        "the data's Hessian does not fit the grid");
  const Eigen::MatrixXd along_depth = depth_laplacian(waves_->depth());
  const double voxel_mm = space.shape.voxel_mm;
  const double mass = std::pow(voxel_mm / options.length_mm, 2);
  const double smooth = options.weight * voxel_mm / space.thickness_mm;
  factors_.resize(static_cast<std::size_t>(waves_->bins()));
  for_rows(waves_->bins(), [&](int bin) {
    Eigen::MatrixXd metric = smooth * along_depth;
    metric.diagonal().array() += smooth * (waves_->mean_laplacian(bin) + mass);
    metric.bottomRows(waves_->depth()) *= std::pow(options.slope / absorbers_vary, 2);
    if (informed) {
      const Eigen::MatrixXd& block = blocks[static_cast<std::size_t>(bin)];
      metric += (1.0 - options.off_diagonal_damping) * block;
      metric.diagonal() += options.off_diagonal_damping * block.diagonal();
    }
    const Eigen::LLT<Eigen::MatrixXd> factored(metric);
    check(factored.info() == Eigen::Success, "the metric of the fit is not positive definite");
    factors_[static_cast<std::size_t>(bin)] = factored.matrixU();
  });
}

void Basis::apply(Factor factor, const Waves& from, double* to) const {
  Eigen::Map<Eigen::MatrixXd> result(to, from.rows(), from.cols());
  for_rows(waves_->bins(), [&](int bin) {
    const std::vector<int>& members = waves_->members(bin);
    const auto upper = factors_[static_cast<std::size_t>(bin)].triangularView<Eigen::Upper>();
    Eigen::MatrixXd part = from(Eigen::all, members);
    switch (factor) {
      case Factor::solve:
        upper.solveInPlace(part);
        break;
      case Factor::solve_transposed:
        upper.transpose().solveInPlace(part);
        break;
      case Factor::multiply:
        part = (upper * part).eval();
        break;
      case Factor::multiply_transposed:
        part = (upper.transpose() * part).eval();
        break;
    }
    result(Eigen::all, members) = part;
  });
}

CoefficientPair Basis::fields_of(const Vector& z, Factor factor) const {
  if (!waves_) return parted(z);
  const Eigen::Index waves = waves_->waves();
  check(static_cast<Eigen::Index>(z.size()) == waves_->rows() * waves,
        "coordinates do not fit the basis");
  Eigen::MatrixXd coefficients(waves_->rows(), waves);
  apply(factor, Waves(z.data(), waves_->rows(), waves), coefficients.data());
  return waves_->synthesise(coefficients);
}

CoefficientPair Basis::to_fields(const Vector& z) const {
  return fields_of(z, Factor::solve);
}

CoefficientPair Basis::gradient_by_field(const Vector& by_z) const {
  return fields_of(by_z, Factor::multiply_transposed);
}

Vector Basis::coordinates_of(const CoefficientPair& fields, Factor factor) const {
  if (!waves_) return joined(fields);
  const Eigen::MatrixXd coefficients = waves_->analyse(fields);
  Vector z(static_cast<std::size_t>(coefficients.size()));
  apply(factor, Waves(coefficients.data(), coefficients.rows(), coefficients.cols()), z.data());
  return z;
}

Vector Basis::from_fields(const CoefficientPair& fields) const {
  return coordinates_of(fields, Factor::multiply);
}

Vector Basis::gradient(const CoefficientPair& by_field) const {
  return coordinates_of(by_field, Factor::solve_transposed);
}

Vector Basis::carried(const Basis& before, const Vector& z, Factor off, Factor on) const {
  check((waves_ == nullptr) == (before.waves_ == nullptr) && cells_ == before.cells_,
        "coordinates of another kind are not carried");
  if (!waves_) return z;
  const auto waves_of = [&](const Vector& v) {
    return Waves(v.data(), waves_->rows(), waves_->waves());
  };
  Vector between(z.size()), result(z.size());
  before.apply(off, waves_of(z), between.data());
  apply(on, waves_of(between), result.data());
  return result;
}

Vector Basis::carried(const Basis& before, const Vector& z) const {
  return carried(before, z, Factor::solve, Factor::multiply);
}

Vector Basis::carried_gradient(const Basis& before, const Vector& by_z) const {
  return carried(before, by_z, Factor::multiply_transposed, Factor::solve_transposed);
}

Eigen::MatrixXd Basis::inverse_factor(int bin) const {
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(waves_->rows(), waves_->rows());
  factors_[static_cast<std::size_t>(bin)].triangularView<Eigen::Upper>().solveInPlace(inverse);
  return inverse;
}

Eigen::MatrixXd Basis::inverse_of(int bin) const {
  const Eigen::MatrixXd factor = inverse_factor(bin);
  return factor * factor.transpose();
}

Eigen::MatrixXd Basis::wave_variances() const {
  check(waves_ != nullptr, "voxels have no waves");
  Eigen::MatrixXd variances(waves_->rows(), waves_->bins());
  for (int bin = 0; bin < waves_->bins(); ++bin) variances.col(bin) = inverse_of(bin).diagonal();
  return variances;
}

FieldCovariance Basis::covariance() const {
  if (!waves_) return {{Vector(cells_, 1.0), Vector(cells_, 1.0)}, Vector(cells_, 0.0)};
  const auto* const modes = dynamic_cast<const LateralModes*>(waves_.get());
  check(modes != nullptr, "the covariance of a part of a block was asked for");
  const Eigen::Index depth = modes->depth();
  Eigen::MatrixXd diagonal(modes->rows(), modes->waves());
  Eigen::MatrixXd between = Eigen::MatrixXd::Zero(diagonal.rows(), diagonal.cols());
  for (int bin = 0; bin < waves_->bins(); ++bin) {
    const Eigen::MatrixXd inverse = inverse_of(bin);
    for (const int wave : waves_->members(bin)) {
      diagonal.col(wave) = inverse.diagonal();
      between.col(wave).head(depth) = inverse.topRightCorner(depth, depth).diagonal();
    }
  }
  return {modes->spread(diagonal), modes->spread(between).log_kappa};
}

double Basis::determined(const LateralBlocks& blocks) const {
  check(waves_ != nullptr, "voxels have no metric");
  Vector of_bin(blocks.size());
  for_rows(waves_->bins(), [&](int bin) {
    const auto k = static_cast<std::size_t>(bin);
    const auto waves = static_cast<double>(waves_->members(bin).size());
    of_bin[k] = waves * inverse_of(bin).cwiseProduct(blocks[k]).sum();
  });
  return std::accumulate(of_bin.begin(), of_bin.end(), 0.0);
}

}  // namespace kappamu::inverse
