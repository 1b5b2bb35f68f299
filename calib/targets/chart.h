// The ColorChecker Classic: where its 24 patches lie in a picture, and what its neutrals reflect.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace kappamu::calib {

/// Luminance factors Y/100 of the six neutral patches (19 white ... 24 black), from the L* of
/// charts made after November 2014 (X-Rite: 95.19, 81.29, 66.89, 50.76, 35.63, 20.64) by CIE
/// 15:2004. The patches are spectrally flat to about 1 %, so each colour channel reflects the same.
std::array<double, 6> neutral_reflectances();

/// Y/100 of a CIE lightness L*.
double luminance_factor(double lightness);

/// Patch outlines in pixels, row by row from dark skin to black.
struct ChartPatches {
  /// Middle half of each patch: corners (left top, right top, right bottom, left bottom) in the
  /// chart's own upright sense.
  std::array<std::array<Eigen::Vector2d, 4>, 24> middles;
  std::array<Eigen::Vector2d, 24> centres;
};

/// From the centres of the dark skin, bluish green, black and white patches.
ChartPatches chart_from_corners(const std::array<Eigen::Vector2d, 4>& corners_px);

/// Pixels (x, y) whose centres lie in a convex quadrilateral.
std::vector<std::array<int, 2>> pixels_inside(const std::array<Eigen::Vector2d, 4>& corners,
                                              int width, int height);

}  // namespace kappamu::calib
