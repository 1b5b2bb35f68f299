// Inner corners of a chessboard in a photograph, in one order whatever way the detector saw it.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "calib/targets/board_corners.h"
#include "core/image.h"

namespace kappamu::calib {

/// Luminance of R, G, B.
inline float luminance_of(const float* rgb) {
  return 0.299F * rgb[0] + 0.587F * rgb[1] + 0.114F * rgb[2];
}

/// Luminance of a three-channel image; a one-channel image as it is.
Image<float> to_grey(const Image<float>& image);

/// Finds the board in a grey image of any linear scale (OpenCV's adaptive detector, then its
/// sector-based one) and refines the corners (corner_fit.h), best where the image is linear in
/// light. `name` is the file, for messages. Throws InputError if the board is not wholly visible.
BoardCorners find_chessboard(const Image<float>& grey, int columns, int rows,
                             const std::string& name);

/// Whether a board has one of fewer corners as a part, turned or not.
bool contains(std::array<int, 2> board, std::array<int, 2> part);

enum class Sizes { all, larger };

/// Inner corners of a board of another size than the stated one: of one more or fewer each way, or
/// of what OpenCV's sector-based detector makes of the picture; the largest that is there. This
/// takes ten times as long as a search. Quick, of larger boards alone, that detector's is tried.
std::optional<std::array<int, 2>> other_chessboard(const Image<float>& grey, int columns, int rows,
                                                   Sizes which = Sizes::all);

/// The chessboard thrown on a plane beside a printed one, `printed` from the plane's own picture.
/// Room light shows the printed board here too: where the detector takes it for the projected one,
/// it is painted over and the search repeated. Throws as find_chessboard does.
BoardCorners find_projected_chessboard(const Image<float>& grey, int columns, int rows,
                                       const BoardCorners& printed, const std::string& name);

/// The upright rule (board_corners.h), applied to corners of either handedness and any start.
/// Public for tests.
void make_upright(BoardCorners& corners);

}  // namespace kappamu::calib
