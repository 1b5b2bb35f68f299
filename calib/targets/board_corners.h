// A printed or projected board as a picture shows it: which of its corners (or dots), and where.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

namespace kappamu::calib {

/// Corners of a board of columns x rows. Boards seen whole have all of them, corner (column i,
/// row j) at pixels[j * columns + i]; boards seen in part (ChArUco, Gray code) name those they have
/// in `lattice`.
///
/// The order is that of the upright rule where nothing on the board tells it: seen in the image,
/// the rows' direction turned clockwise by 90° is the columns' direction (the board is not
/// mirrored), and of the two (for a square board four) orders left, the one whose first row points
/// most to the right. So for a board or projector turned by less than 90° against the camera,
/// corner (0, 0) is the one meant.
struct BoardCorners {
  int columns = 0;
  int rows = 0;
  std::vector<Eigen::Vector2d> pixels;  ///< [row][column], or in the order of `lattice`
  /// Standard deviation of the Gaussian that blurs the board's edges like these, median; 0 where
  /// not measured. About 0.6 px in a sharp picture.
  double blur_px = 0.0;
  /// Whether the square between corners (0, 0) and (1, 1) is dark; unset where a half turn leaves
  /// the squares' colours alone (columns + rows even) or nothing was measured.
  std::optional<bool> first_square_dark = std::nullopt;
  std::vector<int> lattice{};  ///< j * columns + i of each pixel; empty: the board is whole
  /// Every other row lies half a spacing further right (asymmetric circles).
  bool staggered = false;
  bool light_first = false;  ///< ChArUco as OpenCV before 4.6 made them (charuco.h)

  bool whole() const { return lattice.empty(); }
  /// Column and row of pixels[k].
  std::array<int, 2> place(std::size_t k) const {
    const int at = lattice.empty() ? static_cast<int>(k) : lattice[k];
    return {at % columns, at / columns};
  }
  /// Of a whole board.
  const Eigen::Vector2d& at(int column, int row) const {
    return pixels[static_cast<std::size_t>(row) * columns + column];
  }
};

}  // namespace kappamu::calib
