// Where a printed board's corners or dots lie in the board's own frame, sheet bent or flat.
#pragma once

#include <Eigen/Core>
#include <array>

namespace kappamu::calib {

struct BoardShape {
  int columns = 0;         ///< inner corners or dots
  int rows = 0;            ///< the same
  double square_mm = 0.0;  ///< spacing; of staggered boards that of rows, and half that along a row
  bool staggered = false;  ///< asymmetric circles: point (i, j) at square_mm (2 i + j mod 2, j)

  /// On the flat sheet, in spacings.
  Eigen::Vector2d place(int i, int j) const {
    return {staggered ? 2.0 * i + j % 2 : 1.0 * i, 1.0 * j};
  }
  Eigen::Vector3d flat_point(int i, int j) const {
    const Eigen::Vector2d at = square_mm * place(i, j);
    return {at.x(), at.y(), 0.0};
  }
};

/// Corner (i, j) of a sheet bent to a parabola along either axis (as mrcal's board model):
/// z = b0 (1 - u²) + b1 (1 - v²), u, v from -1 to 1 between the outermost corners; b in mm.
template <class T>
Eigen::Matrix<T, 3, 1> bent_corner(const BoardShape& board, const T* bend_mm, int i, int j) {
  const Eigen::Vector3d flat = board.flat_point(i, j);
  const Eigen::Vector2d extent =
      board.square_mm *
      Eigen::Vector2d(board.staggered ? 2 * board.columns - 1 : board.columns - 1, board.rows - 1);
  const double u = extent.x() > 0.0 ? 2.0 * flat.x() / extent.x() - 1.0 : 0.0;
  const double v = extent.y() > 0.0 ? 2.0 * flat.y() / extent.y() - 1.0 : 0.0;
  return {T(flat.x()), T(flat.y()), bend_mm[0] * (1.0 - u * u) + bend_mm[1] * (1.0 - v * v)};
}

}  // namespace kappamu::calib
