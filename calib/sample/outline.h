// The outline of a bright quadrilateral on a dark ground, to sub-pixel precision.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/image.h"

namespace kappamu::calib {

/// Corners clockwise in the picture, starting with the one from which the outline runs most to the
/// right: the top left one as long as the camera is turned by less than 45°.
using Quad = std::array<Eigen::Vector2d, 4>;

/// Coarse outline (a pixel or two) of the largest bright region of a grey image. Throws InputError
/// naming `name` unless there is one, it is a quadrilateral and it lies wholly in the picture.
Quad find_bright_quad(const Image<float>& grey, const std::string& name);

/// Points where the brightness drops fastest across the lines given as point pairs: one list per
/// line, in pixels; searched within `reach` pixels of the line, 8 % of its length left out at
/// either end. `lines[k]` runs clockwise, the bright side to its right (y down).
std::vector<std::vector<Eigen::Vector2d>> edge_points(
    const Image<float>& grey, const std::vector<std::vector<Eigen::Vector2d>>& lines, double reach);

}  // namespace kappamu::calib
