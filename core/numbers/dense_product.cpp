#include "core/numbers/dense_product.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "core/error.h"
#include "core/numbers/widest.h"

namespace kappamu {

namespace {

/// Of the product, held in registers.
constexpr Eigen::Index tile_rows = 8;
constexpr Eigen::Index tile_columns = 8;

typedef double Lanes __attribute__((vector_size(tile_rows * sizeof(double))));  // NOLINT
using Tile = std::array<double, tile_rows * tile_columns>;

/// `panel`: tile_rows rows of the left matrix, one column of them after the other; `b`: columns of
/// the right one.
KAPPAMU_WIDEST void multiply(const double* panel, const std::array<const double*, tile_columns>& b,
                             Eigen::Index inner, Tile& tile) {
  Lanes sum[tile_columns] = {};
  for (Eigen::Index i = 0; i < inner; ++i) {
    Lanes left;
    std::memcpy(&left, panel + i * tile_rows, sizeof left);
    for (std::size_t c = 0; c < tile_columns; ++c) sum[c] += left * b[c][i];
  }
  std::memcpy(tile.data(), sum, sizeof sum);
}

}  // namespace

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  check(a.cols() == b.rows(), "matrices that do not fit cannot be multiplied");
  Eigen::MatrixXd out(a.rows(), b.cols());
  std::vector<double> panel(static_cast<std::size_t>(a.cols() * tile_rows), 0.0);
  Tile tile;
  for (Eigen::Index row = 0; row < a.rows(); row += tile_rows) {
    const Eigen::Index height = std::min(tile_rows, a.rows() - row);
    for (Eigen::Index i = 0; i < a.cols(); ++i) {
      std::copy_n(a.col(i).data() + row, height, panel.begin() + i * tile_rows);
    }
    for (Eigen::Index column = 0; column < b.cols(); column += tile_columns) {
      std::array<const double*, tile_columns> columns{};
      for (Eigen::Index c = 0; c < tile_columns; ++c) {
        columns[static_cast<std::size_t>(c)] = b.col(std::min(column + c, b.cols() - 1)).data();
      }
      multiply(panel.data(), columns, a.cols(), tile);
      const Eigen::Index width = std::min(tile_columns, b.cols() - column);
      for (Eigen::Index c = 0; c < width; ++c) {
        std::copy_n(tile.begin() + c * tile_rows, height, out.col(column + c).data() + row);
      }
    }
  }
  return out;
}

}  // namespace kappamu
