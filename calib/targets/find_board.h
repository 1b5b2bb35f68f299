// A printed board of any kind in a photograph.
#pragma once

#include <string>

#include "calib/targets/board_corners.h"
#include "capture/session/session.h"
#include "core/image.h"

namespace kappamu::calib {

/// Finds the board by the detector of its kind (chessboard.h, charuco.h, circle_grid.h) in a grey
/// image of any linear scale. Throws InputError naming `name`, the file.
BoardCorners find_board(const Image<float>& grey, const capture::Board& board,
                        const std::string& name);

}  // namespace kappamu::calib
