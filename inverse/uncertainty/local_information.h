// The fit's metric takes light for the same across the block. Where light is not, and above all
// below a part of the face that no pixel shows, the data's own say tells it.
#pragma once

#include "inverse/optimise/basis.h"

namespace kappamu::inverse {

/// Variances of a layer shared out among its voxels: the precision beyond that of `beforehand` goes
/// as diag JᵀWJ, so that where the data say nothing the prior's variance stays. `sensitivity` is
/// its root (sensitivity.h); it is averaged over some voxels across the light, since few probes
/// make it.
CoefficientPair shared_out(CoefficientPair variance, const CoefficientPair& beforehand,
                           const CoefficientPair& sensitivity, const MediumSpace& space);

}  // namespace kappamu::inverse
