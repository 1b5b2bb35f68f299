// Centres of the dots of a circle grid in a photograph.
#pragma once

#include <string>

#include "calib/targets/board_corners.h"
#include "capture/session/session.h"
#include "core/image.h"

namespace kappamu::calib {

/// Finds a symmetric or asymmetric grid of dark dots (OpenCV's findCirclesGrid) wholly in view and
/// refines each centre to the centroid of its darkness against a plane of background, within half
/// the distance to the next dot. Symmetric grids follow the upright rule; asymmetric ones are
/// turned so that they are not mirrored. Throws InputError naming `name` if the grid is not found.
///
/// The centroid of a dot's picture is not the picture of its centre: with a dot of radius r at
/// distance Z, tilted by t, it lies f (r/Z)² sin t cos t off. Corrected nowhere; docs/limits.md.
BoardCorners find_circles(const Image<float>& grey, const capture::Board& board,
                          const std::string& name);

}  // namespace kappamu::calib
