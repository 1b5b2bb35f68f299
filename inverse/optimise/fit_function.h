// What a fit minimises at one weight, as a function of the coordinates the
// optimiser moves in.
#pragma once

#include "inverse/optimise/absorption_scale.h"
#include "inverse/optimise/basis.h"
#include "inverse/optimise/optimiser.h"
#include "inverse/problem/objective.h"
#include "inverse/regulariser/roughness.h"

namespace kappamu::inverse {

/// f(z) = ½ χ² + α R in the coordinates the optimiser moves in.
class FitFunction final : public Function {
 public:
  /// `basis` is one of (log κ, w), w as `scale` has it. `start`: the fields the optimiser begins
  /// from, at z = coordinates(start). There value() takes these themselves, not what rounding makes
  /// of them on the way to z and back: what the objective has just solved it need not solve again.
  FitFunction(Objective& objective, const Basis& basis, const Anchor& anchor, double weight,
              const Regulariser& regulariser, CoefficientPair start,
              const AbsorptionScale& scale = {});

  Vector coordinates(const CoefficientPair& fields) const;
  /// Those of the fields that the optimiser begins from.
  const Vector& start_coordinates() const { return start_.z; }
  CoefficientPair fields(const Vector& z) const;

  double value(const Vector& z) override;
  Vector gradient() override;
  double amplitude(const Vector& z, const Vector& direction) override;
  /// Fields of the last value().
  const CoefficientPair& here() const { return here_.fields; }
  /// Of z; empty where they are not the fields that the optimiser began from.
  CoefficientPair start_fields(const Vector& z) const;
  /// The last value() was at z, of these fields, and not this function's (on_device/steps.h).
  void come_to(const Vector& z, CoefficientPair fields);
  const Anchor& anchor() const { return anchor_; }
  double weight() const { return weight_; }
  const Regulariser& regulariser() const { return regulariser_; }
  const AbsorptionScale& scale() const { return scale_; }
  double last_roughness() const { return roughness_.value; }
  /// Translates an L-BFGS pair of `before`, the function of the previous weight, to this function:
  /// `change` becomes the change of this gradient along the step. Exact up to three terms: the new
  /// r, the curvature of the absorption scale, and the diffusivity of Huber-TV, which is that of
  /// the last value().
  void adopt(const FitFunction& before, Vector& step, Vector& change) const;
  /// Predicted decrease of χ² from the minimum `fields` of this weight to the minimum of `weight`.
  /// The metric `basis`, made for `weight`, stands for the Hessian.
  double chi2_gain(const CoefficientPair& fields, const Basis& basis, double weight) const;

 private:
  struct Point {
    Vector z;
    CoefficientPair fields;
  };
  /// Sets here_ to z, whose fields are computed where they are not at hand.
  void go_to(const Vector& z);

  Objective& objective_;
  const Basis& basis_;
  Anchor anchor_;
  double weight_;
  Regulariser regulariser_;
  AbsorptionScale scale_;
  Point start_;
  Point here_;   ///< of the last value()
  Point ahead_;  ///< z + direction of the last amplitude(): mostly the next to be asked for
  Roughness roughness_;
};

}  // namespace kappamu::inverse
