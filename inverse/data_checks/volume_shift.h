// What a fitted volume reveals of a shift between light and images. κ and μ of voxels absorb much
// of one, but grow rougher by it than the data would need them to. The minimum of ½ χ² + α R, R of
// H1 (edges that may lie anywhere hide a shift), over the volume and a shift f of the images
// together, to first order from the fit:
//     f = S⁻¹ Fᵀ (s − J H⁻¹ g),   S = Fᵀ F − Fᵀ J H⁻¹ Jᵀ F,   H = JᵀJ + α R″,   g = Jᵀs − α R′,
// with F and J the derivatives of the weighted prediction by f and by (log κ, log μ), s the
// weighted residual. S⁻¹ is f's covariance under the noise and the prior.
#pragma once

#include <cstdint>

#include "inverse/data_checks/scale_and_shift.h"
#include "inverse/problem/objective.h"
#include "inverse/uncertainty/uncertainty.h"

namespace kappamu::inverse {

/// Of the images against the light, along the axes of the seen face [voxels].
struct VolumeShift {
  Estimate u, v;
};

/// At `fields`, those of the objective's last value(), which `prior` draws to their mean. H⁻¹ by at
/// most `steps` steps of conjugate gradients along each axis, two solves each; fewer than it takes
/// leave f too small.
VolumeShift volume_shift(Objective& objective, const CoefficientPair& fields, const Prior& prior,
                         int steps, std::uint64_t seed);

}  // namespace kappamu::inverse
