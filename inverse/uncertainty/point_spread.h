// How fine a fitted volume is. Of a wave across the light the fit finds the share 1 − C/(α R″)⁻¹ of
// its variances after and before the data (docs/theory.md, 5): that of long waves nearly whole, of
// short ones nothing. The image of a point is a blot. Values and deviations of the volume are means
// over its width.
#pragma once

#include "inverse/optimise/basis.h"

namespace kappamu::inverse {

/// Full widths at half maximum [mm], by slice along the depth, of the Gaussians that pass half of
/// the wave of which the fit finds half; 0 where it finds half of every wave, the block's longest
/// edge where of none.
struct PointSpread {
  Vector kappa_mm, mu_mm;
};

/// From the metrics before and after the data.
PointSpread point_spread(const Basis& prior, const Basis& posterior, const MediumSpace& space);

}  // namespace kappamu::inverse
