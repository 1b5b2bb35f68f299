// Coordinates in which the fit moves. The unknowns are (log κ, log μ) of each voxel; descent in
// those directly is slow, because the data see the surface a thousand times better than the depth
// and smooth fields better than rough ones. So the fit moves in z, u = B z, with B Bᵀ the inverse
// of a guess of the whole Hessian: regulariser (roughness.h, H1) plus, per lateral frequency, the
// data's (lateral_modes.h, lateral_hessian.h). A better guess costs fewer steps; the minimum is the
// same.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "core/names.h"
#include "inverse/optimise/lateral_modes.h"
#include "inverse/problem/fields.h"

namespace kappamu::inverse {

using Vector = std::vector<double>;

enum class Coordinates {
  voxels,   ///< z = (log κ, log μ) of each voxel
  smooth,   ///< the regulariser's metric
  informed  ///< regulariser's and data's
};
inline constexpr Names<Coordinates, 3> coordinates_names{{{"voxels", Coordinates::voxels},
                                                          {"smooth", Coordinates::smooth},
                                                          {"informed", Coordinates::informed}}};

/// The data's Hessian JᵀWJ between depths and coefficients, one symmetric matrix [rows][rows] per
/// bin of lateral frequency.
using LateralBlocks = std::vector<Eigen::MatrixXd>;

/// Variances of (log κ, log μ), and the covariance of the two coefficients of one voxel.
struct FieldCovariance {
  CoefficientPair variance;
  Vector between;
};

struct BasisOptions {
  Coordinates coordinates = Coordinates::informed;
  double length_mm = 1.0;  ///< beyond which the metric no longer favours smoother fields
  double weight = 1.0;     ///< α that the metric is made for
  /// Share by which the correlations between depths and coefficients are lowered in the data's
  /// Hessian.
  double off_diagonal_damping = 0.0;
  double slope = 1.0;  ///< of log μ by the coordinate that stands for it (absorption_scale.h)
};

class Basis {
 public:
  /// `blocks`: used by `informed`; one per bin of LateralModes.
  Basis(const MediumSpace& space, const BasisOptions& options, const LateralBlocks& blocks);
  /// By these waves of the block `space`; one of `blocks` per bin of theirs.
  Basis(std::shared_ptr<const LateralWaves> waves, const MediumSpace& space,
        const BasisOptions& options, const LateralBlocks& blocks);

  CoefficientPair to_fields(const Vector& z) const;
  Vector from_fields(const CoefficientPair& fields) const;
  /// Bᵀ of a gradient with respect to the fields.
  Vector gradient(const CoefficientPair& by_field) const;
  /// The gradient with respect to the fields that gradient() makes `by_z` of: B⁻ᵀ.
  CoefficientPair gradient_by_field(const Vector& by_z) const;
  /// from_fields() of `before`'s to_fields(z), and gradient() of its gradient_by_field(by_z): of
  /// two bases of one block, whose waves are the same.
  Vector carried(const Basis& before, const Vector& z) const;
  Vector carried_gradient(const Basis& before, const Vector& by_z) const;
  /// Covariance B Bᵀ, the approximation of the Hessian's inverse. Of a whole block.
  FieldCovariance covariance() const;
  /// The waves that z has coefficients of; null where it is voxels.
  const LateralWaves* waves() const { return waves_.get(); }
  /// U of one bin, upper triangular.
  const Eigen::MatrixXd& factor(int bin) const { return factors_[static_cast<std::size_t>(bin)]; }
  /// U⁻¹, upper triangular: to_fields() of one bin's waves.
  Eigen::MatrixXd inverse_factor(int bin) const;
  /// Its diagonal among the waves of each bin, [rows][bins]. Not of `voxels`.
  Eigen::MatrixXd wave_variances() const;
  /// tr(B Bᵀ JᵀWJ), JᵀWJ as in `blocks`: how many unknowns the data determine against the
  /// regulariser, by the waves at hand. Not of `voxels`.
  double determined(const LateralBlocks& blocks) const;

 private:
  /// B Bᵀ of one bin's waves.
  Eigen::MatrixXd inverse_of(int bin) const;
  enum class Factor { solve, solve_transposed, multiply, multiply_transposed };
  using Waves = Eigen::Map<const Eigen::MatrixXd>;
  /// `to` = U⁻¹, U⁻ᵀ, U or Uᵀ of every wave's bin times `from`.
  void apply(Factor factor, const Waves& from, double* to) const;
  /// `on` of this basis times `off` of `before`.
  Vector carried(const Basis& before, const Vector& z, Factor off, Factor on) const;
  CoefficientPair fields_of(const Vector& z, Factor factor) const;
  Vector coordinates_of(const CoefficientPair& fields, Factor factor) const;

  std::size_t cells_;
  std::shared_ptr<const LateralWaves> waves_;  ///< null: voxels
  std::vector<Eigen::MatrixXd> factors_;       ///< U of each bin, Uᵀ U = the guess of the Hessian
};

}  // namespace kappamu::inverse
