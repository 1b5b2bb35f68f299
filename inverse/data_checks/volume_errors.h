// Shift between light and images and wrong scale, from a fitted volume. κ and μ of voxels absorb
// much of both, at the price of a rougher volume. ½ χ² + α R is minimised over the volume and these
// errors f together. R is H1's, because edges would hide a shift. To first order from the fit:
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

/// Shift of the images against the light along the axes of the seen face [voxels], and scale of all
/// values, the natural logarithm of the data over what they should be. The volume absorbs most of a
/// wrong scale, but becomes rougher. `scale_gain` is the decrease of the objective if the values
/// were changed by log_scale, over α R; negative where they would be raised. Both are unknown for a
/// block lit and seen on one face: its deep layers absorb any scale.
struct VolumeErrors {
  Estimate shift_u, shift_v;
  std::optional<Estimate> log_scale;
  double scale_gain = 0.0;
};

/// Steps of conjugate gradients for H⁻¹, two solves each. Too few make scale_gain too small.
struct ErrorSteps {
  int most = 0;           ///< for each error
  int early = 0;          ///< after which a scale is given up
  double least_gain = 0;  ///< if scale_gain is below this
};

/// At `fields`, those of the objective's last value(), which `prior` draws to their mean.
VolumeErrors volume_errors(Objective& objective, const CoefficientPair& fields, const Prior& prior,
                           const ErrorSteps& steps, std::uint64_t seed);

}  // namespace kappamu::inverse
