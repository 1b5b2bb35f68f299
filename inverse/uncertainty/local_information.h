// The fit's metric assumes equal light everywhere across the block. The diagonal of the local
// Hessian corrects the variances where the light varies or no pixel sees the voxels.
#pragma once

#include "inverse/optimise/basis.h"

namespace kappamu::inverse {

/// Distributes the variances of a layer among its voxels: the precision beyond that of `beforehand`
/// is made proportional to diag JᵀWJ. Voxels without data keep the prior's variance. `sensitivity`
/// is the root of diag JᵀWJ (sensitivity.h). It comes from few probes and is therefore averaged
/// over neighbouring voxels across the light.
CoefficientPair distributed(CoefficientPair variance, const CoefficientPair& beforehand,
                            const CoefficientPair& sensitivity, const MediumSpace& space);

}  // namespace kappamu::inverse
