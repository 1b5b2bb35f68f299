// Corners of a ChArUco board: a chessboard with a coded marker in each light square, so that a part
// of it is enough.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calib/targets/board_corners.h"
#include "capture/session/session.h"
#include "core/image.h"

namespace kappamu::calib {

/// Finds the corners between markers that are seen (OpenCV's ArUco detector), refined as a
/// chessboard's in a window that leaves the markers out. At least eight corners in two rows and two
/// columns are needed. Corner (0, 0) adjoins marker 0, whatever way the board is turned. Boards of
/// an even number of rows of squares have two layouts, dark square first and, as OpenCV before 4.6
/// made them, light square first: the markers tell which. Throws InputError naming `name` if there
/// are none, markers are of another dictionary (named), or lie as on a board of other columns
/// (named).
BoardCorners find_charuco(const Image<float>& grey, const capture::Board& board,
                          const std::string& name);

/// Cells of marker `id`, black border included: side x side, row by row, 1 = light. The board's
/// markers are numbered row by row over its light squares, the square at the top left being dark.
struct MarkerCells {
  int side = 0;
  std::vector<std::uint8_t> light;
};
MarkerCells marker_cells(const std::string& dictionary, int id);

}  // namespace kappamu::calib
