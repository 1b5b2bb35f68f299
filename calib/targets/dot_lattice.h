// Which of the dots in a picture form a printed grid, and in what order.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

namespace kappamu::calib {

/// Dots on a lattice: columns x rows, every other row half a spacing further right if staggered.
struct DotGrid {
  int columns = 0;
  int rows = 0;
  bool staggered = false;

  std::size_t count() const { return static_cast<std::size_t>(columns) * rows; }
};

struct DotSearch {
  /// Centres [row][column], upright (board_corners.h); empty where the grid was not
  /// found, or where dots of a larger one leave several places for it.
  std::vector<Eigen::Vector2d> grid;
  /// Of a grid of another make that uses all dots of the lattice, the kind that was asked for
  /// preferred.
  std::optional<DotGrid> other;
};

/// Follows the lattice from dot to dot, each step predicted by the last one in its direction, and
/// looks for the grid's outline among all ways to number the lattice that do not mirror it. Other
/// marks in the picture do no harm unless they continue the lattice.
DotSearch find_dot_grid(const std::vector<Eigen::Vector2d>& dots, const DotGrid& wanted);

}  // namespace kappamu::calib
