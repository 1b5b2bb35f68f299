// Which projector pixel each camera pixel sees, found by whatever code, and points of the
// projector's frame located in the camera's picture by it.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "calib/targets/board_corners.h"
#include "capture/session/session.h"
#include "core/image.h"

namespace kappamu::calib {

/// Frame n of a code, grey: read when it is wanted, as all together would not fit into memory.
/// Called from several threads.
using FrameSource = std::function<Image<float>(std::size_t n)>;

struct ProjectorMap {
  Image<float> pixel;    ///< [y][x][2] projector column and row; valid where quality > 0
  Image<float> quality;  ///< [y][x] contrast of what was read, at most 1; 0: not legible

  double legible_share() const;  ///< of all pixels
};

/// Means over square blocks of the smallest size that leaves no side longer than `longest` pixels.
Image<float> block_means(const Image<float>& map, int longest);

/// Points to locate: a lattice over the projector's frame, 24 columns of them.
capture::ProjectedBoard map_lattice(const capture::Projector& projector);

/// The lattice's points in camera pixels: the local homography from camera to projector pixels
/// (Moreno & Taubin 2012) over the cell about each, outliers beyond 1.5 projector pixels left out,
/// taken backwards. Points whose cell is not legible on all four sides are missing. Throws
/// InputError naming `name` where fewer than 12 points in three rows and columns are found.
BoardCorners mapped_corners(const ProjectorMap& map, const capture::ProjectedBoard& lattice,
                            const std::string& name);

/// Those of `points` on the plane of the printed board, without what lies behind or beside it: one
/// perspective view of the lattice, grown from the points on the board (or, where the projector
/// does not reach that, from the largest plane), within 0.6 % of `width_px`, the picture's width,
/// as lens distortion bends it. Throws as mapped_corners.
BoardCorners points_on_plane(const BoardCorners& points, const BoardCorners& printed, int width_px,
                             const std::string& name);

}  // namespace kappamu::calib
