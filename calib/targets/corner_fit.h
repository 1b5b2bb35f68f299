// Corners of a chessboard to a few thousandths of a pixel: the picture about each is fitted.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "calib/targets/board_corners.h"
#include "core/image.h"

namespace kappamu::calib {

/// Which pixels about a corner show its own two edges and nothing else.
struct CornerWindow {
  /// Steps [px] to the next corner along the row and along the column, as columns.
  Eigen::Matrix2d steps;
  /// Distance from the nearer edge in steps: below 1 where something else is printed in the squares
  /// (markers).
  double clear = 1.0;
  double longest_px = 11.0;  ///< along each edge: those bent by the lens pull beyond
};

/// Least squares over the pixels about `start`, at most longest_px and 0.8 steps along each edge,
/// of
///   I(x) = (1 + s·(x - c)) (m + b P + q P²),   P = S(n₁·(x - c)) S(n₂·(x - c)),
/// with c the corner, n₁ and n₂ the edges' normals, S the sign of a distance blurred by a Gaussian
/// and averaged over the pixel, and s the shading. All but the shading is symmetric about c, so
/// that blur, ink that bleeds and the camera's response do not move it; q takes what the response
/// does to the greys of an edge. Nothing if the picture there is no such corner within two pixels.
std::optional<Eigen::Vector2d> fit_corner(const Image<float>& grey, const Eigen::Vector2d& start,
                                          const CornerWindow& window);

/// Refines the corners of a chessboard or ChArUco board: by gradients (Förstner & Gülch 1987) in
/// windows of at most 23 x 23 px that end `clear` of a step from the corner, after a Gaussian of at
/// most 1.5 px, then by fit_corner. A corner that it does not take there is tried again from
/// where it was, in half the window, and else stays where the gradients put it.
void refine_corners(const Image<float>& grey, BoardCorners& corners, double clear = 1.0);

/// Of corners found on the picture made `factor` as large, whose pixels they are a few of the whole
/// one's off: by that picture first.
void refine_corners_from(double factor, const Image<float>& grey, BoardCorners& corners,
                         double clear = 1.0);

}  // namespace kappamu::calib
