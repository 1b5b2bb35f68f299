// The optimiser's coordinate for μ. The data depend on μ, the regulariser on log μ. In log μ the
// data's Hessian grows as μ², so that no uniform metric fits the whole block. w = sinh(log μ/μ₀) is
// proportional to μ above μ₀ and to log μ below. In w the data's Hessian is nearly independent of
// μ, and the regulariser's falls more slowly than 1/μ².
#pragma once

#include "inverse/problem/fields.h"

namespace kappamu::inverse {

class AbsorptionScale {
 public:
  /// log μ itself.
  AbsorptionScale() = default;
  /// μ₀ = `mu` [1/mm].
  explicit AbsorptionScale(double mu) : mu_(mu) {}
  /// μ₀ [1/mm]; 0: w is log μ itself.
  double mu() const { return mu_; }

  /// (log κ, w) from (log κ, log μ), and back.
  CoefficientPair from_fields(CoefficientPair fields) const;
  CoefficientPair to_fields(CoefficientPair scaled) const;
  /// Derivatives by (log κ, w) of those by (log κ, log μ) at `fields`; also a change of log μ of a
  /// change of w there. The factor of both is ∂ log μ/∂w.
  CoefficientPair by_scaled(const CoefficientPair& fields, CoefficientPair by_fields) const;
  /// Root mean square of ∂ log μ/∂w.
  double mean_slope(const CoefficientPair& fields) const;

 private:
  template <class Work>
  void for_parts(std::size_t voxels, const Work& work) const;

  double mu_ = 0.0;  ///< μ₀; 0: w = log μ
};

}  // namespace kappamu::inverse
