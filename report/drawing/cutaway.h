// The block from outside with a corner cut away: where its material differs, at a glance.
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid.h"
#include "core/image.h"

namespace kappamu::report {

/// Orthographic, x to the right, y down, z away from the viewer, seen from above and from the
/// right, so that the lit face's side, the first y and the last x are in view; the octant between
/// them is cut away. A voxel has the colour of white light that a thick piece of its material sends
/// back (Flock et al. 1992, reduced albedo 1 − 3κμ), the brightest percentile white. One channel,
/// or R, G, B. White where no voxel is.
Image<std::uint8_t> cutaway(const std::vector<Medium>& channels, double eta, int width);

}  // namespace kappamu::report
