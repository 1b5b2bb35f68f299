// What a fit minimises at one weight, as a function of the coordinates the
// optimiser moves in.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "inverse/basis.h"
#include "inverse/objective.h"
#include "inverse/optimiser.h"
#include "inverse/roughness.h"
#include "inverse/uncertainty.h"

namespace kappamu::inverse {

/// f(z) = ½ χ² + α R in the coordinates the optimiser moves in.
class FitFunction final : public Function {
 public:
  /// `start`: the fields the optimiser begins from, at z = basis.from_fields(start). There value()
  /// takes these themselves, not what rounding makes of them on the way to z and back: what the
  /// objective has just solved it need not solve again.
  FitFunction(Objective& objective, const Basis& basis, double thickness_mm, const Anchor& anchor,
              double weight, const Regulariser& regulariser, CoefficientPair start)
      : objective_(objective),
        basis_(basis),
        thickness_mm_(thickness_mm),
        anchor_(anchor),
        weight_(weight),
        regulariser_(regulariser),
        start_(std::move(start)),
        start_z_(basis.from_fields(start_)) {}

  double value(const Vector& z) override {
    const CoefficientPair fields = z == start_z_ ? start_ : basis_.to_fields(z);
    roughness_ =
        roughness(objective_.problem().setup.shape, thickness_mm_, fields, anchor_, regulariser_);
    return objective_.value(fields) + weight_ * roughness_.value;
  }
  Vector gradient() override {
    CoefficientPair sum = objective_.gradient();
    for (std::size_t i = 0; i < sum.log_mu.size(); ++i) {
      sum.log_kappa[i] += weight_ * roughness_.gradient.log_kappa[i];
      sum.log_mu[i] += weight_ * roughness_.gradient.log_mu[i];
    }
    return basis_.gradient(sum);
  }
  /// BᵀJᵀWJB + α BᵀR''B, for H1 and Huber-TV (its diffusivity lagged) and Gaussian data.
  Vector curvature(const Vector& direction) override {
    const Prior prior{weight_, weight_, thickness_mm_, anchor_.length_mm, roughness_.diffusivity};
    return basis_.gradient(hessian_product(objective_, prior, basis_.to_fields(direction)));
  }
  double last_roughness() const { return roughness_.value; }
  double amplitude(const Vector& direction) const override {
    const CoefficientPair fields = basis_.to_fields(direction);
    double largest = 0.0;
    for (const double x : fields.log_kappa) largest = std::max(largest, std::abs(x));
    for (const double x : fields.log_mu) largest = std::max(largest, std::abs(x));
    return largest;
  }

 private:
  Objective& objective_;
  const Basis& basis_;
  double thickness_mm_;
  Anchor anchor_;
  double weight_;
  Regulariser regulariser_;
  CoefficientPair start_;
  Vector start_z_;
  Roughness roughness_;
};

}  // namespace kappamu::inverse
