// Where a printed board's corners lie in the board's own frame, sheet bent or flat.
#pragma once

#include <Eigen/Core>
#include <array>

namespace kappamu::calib {

struct BoardShape {
  int columns = 0;         ///< inner corners
  int rows = 0;            ///< inner corners
  double square_mm = 0.0;  ///< spacing of the corners
};

/// Corner (i, j) of a sheet bent to a parabola along either axis (as mrcal's board model):
/// z = b0 (1 - u²) + b1 (1 - v²), u, v from -1 to 1 between the outermost corners; b in mm.
template <class T>
Eigen::Matrix<T, 3, 1> bent_corner(const BoardShape& board, const T* bend_mm, int i, int j) {
  const double u = board.columns > 1 ? 2.0 * i / (board.columns - 1) - 1.0 : 0.0;
  const double v = board.rows > 1 ? 2.0 * j / (board.rows - 1) - 1.0 : 0.0;
  return {T(board.square_mm * i), T(board.square_mm * j),
          bend_mm[0] * (1.0 - u * u) + bend_mm[1] * (1.0 - v * v)};
}

}  // namespace kappamu::calib
