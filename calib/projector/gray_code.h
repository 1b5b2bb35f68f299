// Which projector pixel each camera pixel sees, from a projected Gray code, and points of the
// projector's frame located in the camera's picture by it.
#pragma once

#include <string>
#include <vector>

#include "calib/targets/board_corners.h"
#include "capture/session/session.h"
#include "core/image.h"

namespace kappamu::calib {

struct GrayCodeMap {
  Image<float> pixel;  ///< [y][x][2] projector column and row; valid where quality > 0
  /// [y][x] contrast of the weakest bit read: |pattern - inverse| over white - black, at most 1. 0
  /// where the code is not legible.
  Image<float> quality;

  double legible_share() const;  ///< of all pixels
};

/// Reads the frames of ProjectorPlane::gray_code, grey and of equal size, in any linear or monotone
/// scale. A pixel is legible where white exceeds black by 4 % of the brightest, every bit differs
/// from its inverse by 2 % of it (OpenCV structured_light's rule with both thresholds at 5 of 255
/// gives the same codes, tests/calib/projector/gray_code_test.cpp), and the code lies in the
/// projector's frame. The finest bit of columns or rows may be illegible, as where the camera's
/// pixels are as wide as the projector's: its edges run through the middle of the two pixels that
/// it tells apart, and that is what such a pixel sees.
GrayCodeMap decode_gray_code(const std::vector<Image<float>>& frames,
                             const capture::Projector& projector);

/// Means over square blocks of the smallest size that leaves no side longer than `longest` pixels.
Image<float> block_means(const Image<float>& map, int longest);

/// Points to locate: a lattice over the projector's frame, 24 columns of them.
capture::ProjectedBoard gray_code_lattice(const capture::Projector& projector);

/// The lattice's points in camera pixels: the local homography from camera to projector pixels
/// (Moreno & Taubin 2012) over the cell about each, outliers beyond 1.5 projector pixels left out,
/// taken backwards. Points whose cell is not legible on all four sides are missing. Throws
/// InputError naming `name` where fewer than 12 points in three rows and columns are found.
BoardCorners gray_code_corners(const GrayCodeMap& map, const capture::ProjectedBoard& lattice,
                               const std::string& name);

/// Those of `points` on the plane of the printed board, without what lies behind or beside it: one
/// perspective view of the lattice, grown from the points on the board (or, where the projector
/// does not reach that, from the largest plane), within 0.6 % of `width_px`, the picture's width,
/// as lens distortion bends it. Throws as gray_code_corners.
BoardCorners points_on_plane(const BoardCorners& points, const BoardCorners& printed, int width_px,
                             const std::string& name);

}  // namespace kappamu::calib
