#include "calib/targets/find_board.h"

#include "calib/targets/charuco.h"
#include "calib/targets/chessboard.h"
#include "calib/targets/circle_grid.h"
#include "core/error.h"

namespace kappamu::calib {

BoardCorners find_board(const Image<float>& grey, const capture::Board& board,
                        const std::string& name) {
  switch (board.kind) {
    case capture::BoardKind::chessboard:
      return find_chessboard(grey, board.columns, board.rows, name);
    case capture::BoardKind::charuco:
      return find_charuco(grey, board, name);
    case capture::BoardKind::circles:
    case capture::BoardKind::asymmetric_circles:
      return find_circles(grey, board, name);
  }
  throw InternalError("internal error: unknown kind of board");
}

}  // namespace kappamu::calib
