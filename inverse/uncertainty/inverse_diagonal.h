// The diagonal of H⁻¹ for a symmetric positive definite H over (log κ, log μ) that is only known by
// its products, here the covariance of a fit (uncertainty.h).
//
// Random vectors u of unit covariance give x = B A^(−½) u with A = Bᵀ H B, so that E[x xᵀ] = H⁻¹
// (sampling: Papandreou & Yuille 2010; the square root by Lanczos' method in the coordinates of a
// preconditioner: Chow & Saad 2014). The metric B Bᵀ, a guess of H⁻¹, has a known diagonal, and
// y = B u has that covariance exactly: what x and y have in common cancels in
//     var_i = (B Bᵀ)_ii Σ x² / Σ y²,
// a ratio that varies slowly across the light, so that few samples and a mean over neighbours of
// the same depth tell it. Unlike a low-rank update of the prior, the cost does not grow with the
// number of directions that the data determine.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "inverse/optimise/basis.h"

namespace kappamu::inverse {

/// v ↦ H v.
using FieldOperator = std::function<CoefficientPair(const CoefficientPair&)>;

class InverseDiagonal {
 public:
  /// `steps` ≥ 1: products with H spent on each sample. `basis` must outlive this.
  InverseDiagonal(FieldOperator hessian, const GridShape& shape, int depth_axis, const Basis& basis,
                  int steps);

  /// Adds the sample of `u`, in the basis' coordinates; the u of all samples are independent with
  /// unit covariance.
  void add(const Vector& u);

  /// From the samples so far; without any, that of the metric. `pooling`: standard deviation of the
  /// Gaussian mean across the light [voxels]; 0 = each voxel for itself.
  FieldCovariance result(double pooling) const;

  /// Size of the last Lanczos coefficient against all, the worst sample's: what more steps would
  /// still change.
  double unfinished() const { return unfinished_; }

 private:
  /// B A^(−½) u.
  CoefficientPair sample(const Vector& u);

  FieldOperator hessian_;
  GridShape shape_;
  int depth_axis_;
  const Basis& basis_;
  int steps_;
  FieldCovariance metric_;    ///< of B Bᵀ
  FieldCovariance samples_;   ///< Σ x², Σ x_κ x_μ, in units of the metric
  FieldCovariance controls_;  ///< the same of y
  int count_ = 0;
  double unfinished_ = 0.0;
};

}  // namespace kappamu::inverse
