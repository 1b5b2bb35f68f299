// Centres of the dots of a circle grid in a photograph.
#pragma once

#include <string>

#include "calib/targets/board_corners.h"
#include "capture/session/session.h"
#include "core/image.h"

namespace kappamu::calib {

/// Finds a symmetric or asymmetric grid of dark dots on light or, where there is none, of light
/// dots on dark, wholly in view (OpenCV's blob detector, ordered by dot_lattice.h), and refines
/// each centre to the centroid of its darkness against a plane of background, within half the
/// distance to the next dot. Grids follow the upright rule and are never mirrored: half a turn
/// leaves symmetric grids and asymmetric ones with even rows alike. Throws InputError naming `name`
/// if the grid is not found, and the grid that is there if it is of another make.
///
/// The centroid of a dot's picture is not the picture of its centre: with a dot of radius r at
/// distance Z, tilted by t, it lies f (r/Z)² sin t cos t off. Corrected nowhere; docs/limits.md.
BoardCorners find_circles(const Image<float>& grey, const capture::Board& board,
                          const std::string& name);

}  // namespace kappamu::calib
