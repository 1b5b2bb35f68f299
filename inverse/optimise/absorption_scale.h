// What the optimiser moves in place of log μ. The data see μ itself, the regulariser its logarithm:
// in log μ the data's Hessian grows by μ², and a metric that is the same everywhere fits only part
// of a block. w = sinh(log μ/μ₀) goes as μ where μ is above μ₀ and as log μ below, so that the one
// Hessian hardly depends on μ and the other does so less than by 1/μ².
#pragma once

#include "inverse/problem/fields.h"

namespace kappamu::inverse {

class AbsorptionScale {
 public:
  /// log μ itself.
  AbsorptionScale() = default;
  /// μ₀ = `mu` [1/mm].
  explicit AbsorptionScale(double mu) : mu_(mu) {}

  /// (log κ, w) from (log κ, log μ), and back.
  CoefficientPair from_fields(CoefficientPair fields) const;
  CoefficientPair to_fields(CoefficientPair scaled) const;
  /// By (log κ, w) of what is by (log κ, log μ) at `fields`, and a change of w as one of log μ
  /// there: the same factor ∂ log μ/∂w.
  CoefficientPair by_scaled(const CoefficientPair& fields, CoefficientPair by_fields) const;
  /// Root mean square of ∂ log μ/∂w.
  double mean_slope(const CoefficientPair& fields) const;

 private:
  template <class Each>
  void for_mu(std::vector<double>& values, const Each& each) const;

  double mu_ = 0.0;  ///< μ₀; 0: w = log μ
};

}  // namespace kappamu::inverse
