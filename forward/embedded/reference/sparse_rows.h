// Sparse matrices by rows, applied to fields of several lanes (right-hand sides): [row][lane],
// lanes innermost, so that one pass over the matrix serves them all.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "forward/embedded/equations/row_ranges.h"

namespace kappamu::forward::embedded {

template <class T>
struct SparseRows {
  std::vector<std::size_t> start{0};  ///< of each row, and the end of the last
  std::vector<int> column;
  std::vector<T> value;

  std::size_t rows() const { return start.size() - 1; }
};

/// Calls use(row, sums) with the row's product with x, one sum per lane.
template <int lanes, class T, class Field, class Use>
void for_products(const SparseRows<T>& matrix, const Field* x, const Use& use) {
  for_row_ranges(matrix.rows(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      std::array<Field, lanes> sum{};
      for (std::size_t k = matrix.start[row]; k < matrix.start[row + 1]; ++k) {
        const Field value = static_cast<Field>(matrix.value[k]);
        const Field* from = x + static_cast<std::size_t>(matrix.column[k]) * lanes;
        for (int lane = 0; lane < lanes; ++lane)
          sum[static_cast<std::size_t>(lane)] += value * from[lane];
      }
      use(row, sum);
    }
  });
}

/// The matrix with rows and columns exchanged.
template <class T>
SparseRows<T> transposed(const SparseRows<T>& matrix, std::size_t columns) {
  SparseRows<T> result;
  result.start.assign(columns + 1, 0);
  for (const int column : matrix.column) ++result.start[static_cast<std::size_t>(column) + 1];
  for (std::size_t c = 0; c < columns; ++c) result.start[c + 1] += result.start[c];
  result.column.resize(matrix.column.size());
  result.value.resize(matrix.value.size());
  std::vector<std::size_t> next(result.start.begin(), result.start.end() - 1);
  for (std::size_t row = 0; row < matrix.rows(); ++row) {
    for (std::size_t k = matrix.start[row]; k < matrix.start[row + 1]; ++k) {
      const std::size_t place = next[static_cast<std::size_t>(matrix.column[k])]++;
      result.column[place] = static_cast<int>(row);
      result.value[place] = matrix.value[k];
    }
  }
  return result;
}

}  // namespace kappamu::forward::embedded
