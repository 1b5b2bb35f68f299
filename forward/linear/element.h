// Trilinear elements: what a cell of eight corners adds to assembled equations.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace kappamu::forward::linear {

/// A symmetric 8 × 8 matrix, its upper half row by row; nodes as corners of the cell, x fastest.
struct Element {
  static constexpr std::size_t entries = 36;
  std::array<double, entries> entry{};

  static constexpr std::size_t place(std::size_t i, std::size_t j) {
    return i <= j ? 8 * i - i * (i + 1) / 2 + j : place(j, i);
  }
  double operator()(std::size_t i, std::size_t j) const { return entry[place(i, j)]; }
};

/// The eight trilinear functions at a point of the unit cube, in a cell's own coordinates.
inline std::array<double, 8> shape_functions(const Eigen::Vector3d& point) {
  std::array<double, 8> n;
  for (std::size_t i = 0; i < 8; ++i) {
    n[i] = ((i & 1) ? point.x() : 1.0 - point.x()) * ((i & 2) ? point.y() : 1.0 - point.y()) *
           ((i & 4) ? point.z() : 1.0 - point.z());
  }
  return n;
}

}  // namespace kappamu::forward::linear
