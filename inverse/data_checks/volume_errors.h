// What a fitted volume reveals of a shift between light and images and of a wrong scale. κ and μ of
// voxels absorb much of both, but grow rougher by it than the data would need them to. The minimum
// of ½ χ² + α R, R of H1 (edges that may lie anywhere hide a shift), over the volume and these
// errors f together, to first order from the fit:
//     f = S⁻¹ Fᵀ (s − J H⁻¹ g),   S = Fᵀ F − Fᵀ J H⁻¹ Jᵀ F,   H = JᵀJ + α R″,   g = Jᵀs − α R′,
// with F and J the derivatives of the weighted prediction by f and by (log κ, log μ), s the
// weighted residual. S⁻¹ is f's covariance under the noise and the prior.
#pragma once

#include <cstdint>
#include <optional>

#include "inverse/data_checks/scale_and_shift.h"
#include "inverse/problem/objective.h"
#include "inverse/uncertainty/uncertainty.h"

namespace kappamu::inverse {

/// Of the images against the light, along the axes of the seen face [voxels], and of all values:
/// the natural logarithm of the data over what they should be. The volume and its prior hide most
/// of the latter, but pay for it: `paid_for_scale` is by how much the objective would fall if
/// values were changed by log_scale, over α R, negative where they would be raised. Of a block lit
/// and seen on one face, whose deep layers hardly show and take up any scale, neither is known.
struct VolumeErrors {
  Estimate shift_u, shift_v;
  std::optional<Estimate> log_scale;
  double paid_for_scale = 0.0;
};

/// Of conjugate gradients for H⁻¹, two solves each: fewer than it takes leave it too small.
struct ErrorSteps {
  int most = 0;            ///< for each error
  int telling = 0;         ///< after which a scale is left
  double hardly_paid = 0;  ///< if less than so much is paid for it
};

/// At `fields`, those of the objective's last value(), which `prior` draws to their mean.
VolumeErrors volume_errors(Objective& objective, const CoefficientPair& fields, const Prior& prior,
                           const ErrorSteps& steps, std::uint64_t seed);

}  // namespace kappamu::inverse
