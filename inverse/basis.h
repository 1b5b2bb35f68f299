// Coordinates in which the fit moves. The unknowns u = (log κ, log μ) are one smooth field each; in
// the basis of cosines, scaled by the inverse square root of the smoothing operator, the
// regulariser is the identity (but for the mean) and the data's Hessian decays quickly, so that the
// number of iterations does not grow with the grid.
//
// Regulariser, per weight α: R = ½ Σ_{κ,μ} ∫|∇u|² dV / ℓ = ½ (h/ℓ) Σ_faces (u_i − u_j)², ℓ the
// thickness of the block along the light. R is dimensionless and does not change with the grid or
// the unit of length.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/grid.h"
#include "inverse/adjoint.h"

namespace kappamu::inverse {

using Vector = std::vector<double>;

enum class Coordinates {
  voxels,  ///< z = (log κ, log μ) of each voxel
  smooth   ///< scaled cosines: the regulariser's own metric
};

class Basis {
 public:
  /// `thickness_mm` is ℓ; `length_mm` the distance beyond which the smooth metric no longer favours
  /// smoother fields.
  Basis(Coordinates coordinates, const GridShape& shape, double thickness_mm, double length_mm);

  std::size_t size() const { return 2 * shape_.cells(); }
  Coordinates coordinates() const { return coordinates_; }

  CoefficientPair to_fields(const Vector& z) const;
  Vector from_fields(const CoefficientPair& fields) const;
  /// Bᵀ of a gradient with respect to the fields.
  Vector gradient(const CoefficientPair& by_field) const;
  /// R(z) and R's gradient, which is linear in z: R = ½ zᵀ roughness_gradient(z).
  double roughness(const Vector& z) const;
  Vector roughness_gradient(const Vector& z) const;

 private:
  void cosine_transform(std::span<double> volume, bool inverse) const;

  Coordinates coordinates_;
  GridShape shape_;
  double voxel_over_thickness_ = 1.0;
  std::vector<Eigen::MatrixXd> cosines_;  ///< orthonormal DCT-II of each axis, [frequency][voxel]
  Vector scale_;                          ///< per cosine: field amplitude per unit coordinate
  Vector rough_;                          ///< per cosine: R = ½ Σ rough z², in [0, 1)
};

}  // namespace kappamu::inverse
