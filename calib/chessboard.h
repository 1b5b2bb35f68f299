// Inner corners of a chessboard in a photograph, in one order whatever way the detector saw it.
#pragma once

#include <string>

#include "calib/board_corners.h"
#include "core/image.h"

namespace kappamu::calib {

/// Luminance (0.299, 0.587, 0.114) of a three-channel image; a one-channel image as it is.
Image<float> to_grey(const Image<float>& image);

/// How corners are refined. Defaults from 216 rendered corners of known place (spacing 13 to 30 px,
/// 1 % noise): RMS error 0.036 px, against 0.085 px with an 11 x 11 window (half 5) and no
/// smoothing, the values in common use. Smoothing helps because the gradients are differences of
/// neighbouring pixels, which a sharp edge aliases.
struct CornerRefinement {
  int half_window_px = 11;    ///< at most; cut to 0.4 of the smallest corner spacing
  double smoothing_px = 1.5;  ///< standard deviation of the Gaussian before, at most a third of the
                              ///< half window; 0 = none
};

/// Finds the board in a grey image of any linear scale and refines the corners to sub-pixel
/// precision (OpenCV's adaptive detector, then its sector-based one; gradient refinement of
/// Förstner and Gülch 1987 in a window that stays within the adjoining squares). `name` is the
/// file, for messages. Throws InputError if the board is not wholly visible.
BoardCorners find_chessboard(const Image<float>& grey, int columns, int rows,
                             const std::string& name, const CornerRefinement& refinement = {});

/// The chessboard thrown on a plane beside a printed one, `printed` from the plane's own picture.
/// Room light shows the printed board here too: where the detector takes it for the projected one,
/// it is painted over and the search repeated. Throws as find_chessboard does.
BoardCorners find_projected_chessboard(const Image<float>& grey, int columns, int rows,
                                       const BoardCorners& printed, const std::string& name);

/// The upright rule (board_corners.h), applied to corners of either handedness and any start.
/// Public for tests.
void make_upright(BoardCorners& corners);

}  // namespace kappamu::calib
