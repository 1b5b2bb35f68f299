// Where the data constrain the volume: the diagonal of the weighted normal matrix.
#pragma once

#include <span>

#include "inverse/problem/fields.h"

namespace kappamu::inverse {

/// √diag(JᵀWJ) for log κ and log μ of each voxel [standard deviations of the data per unit of log],
/// from random_rows() (lateral_hessian.h; Bekas, Kokiopoulou & Saad 2007); relative error of each
/// voxel about √(1/(2 rows)).
CoefficientPair estimate_sensitivity(std::span<const CoefficientPair> rows);

}  // namespace kappamu::inverse
