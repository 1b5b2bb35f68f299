// Where the data constrain the volume: the diagonal of the weighted normal matrix.
#pragma once

#include <cstdint>

#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// √diag(JᵀWJ) for log κ and log μ of each voxel [standard deviations of the data per unit of log],
/// at the fields of the objective's last value(). Estimated from `probes` adjoint solves with
/// random signs on the data (Bekas, Kokiopoulou & Saad 2007); relative error of each voxel about
/// √(1/(2 probes)).
CoefficientPair estimate_sensitivity(Objective& objective, int probes, std::uint64_t seed);

}  // namespace kappamu::inverse
