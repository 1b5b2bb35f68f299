// Sparse matrices by rows, of several media (colour channels) at once, applied to fields of several
// lanes (right-hand sides): [row][lane], lanes innermost, so that one pass over the matrix serves
// them all.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::forward::linear {

/// Which entries a matrix has.
struct RowPattern {
  std::vector<std::uint32_t> start{0};  ///< of each row, and the end of the last
  std::vector<int> column;

  std::size_t rows() const { return start.size() - 1; }
};

/// Matrices of one pattern, one per medium.
template <class T>
struct RowMatrix {
  std::shared_ptr<const RowPattern> pattern;
  std::vector<T> value;  ///< [entry][medium]

  std::size_t rows() const { return pattern->rows(); }
  template <class Other>
  RowMatrix<Other> rounded() const {
    return {pattern, std::vector<Other>(value.begin(), value.end())};
  }
};

/// A row under construction: some tens of entries, each with a value per medium.
class RowSum {
 public:
  RowSum(std::size_t columns, std::size_t media) : media_(media), place_(columns, -1) {}
  void clear() {
    for (const int column : column_) place_[static_cast<std::size_t>(column)] = -1;
    column_.clear();
    value_.clear();
  }
  /// The values at a column, [medium], zero at first; valid until the next call.
  double* at(int column) {
    int& place = place_[static_cast<std::size_t>(column)];
    if (place < 0) {
      place = static_cast<int>(column_.size());
      column_.push_back(column);
      value_.resize(value_.size() + media_, 0.0);
    }
    return value_.data() + static_cast<std::size_t>(place) * media_;
  }
  const std::vector<int>& columns() const { return column_; }
  const std::vector<double>& values() const { return value_; }

 private:
  std::size_t media_;
  std::vector<int> column_;
  std::vector<double> value_;
  std::vector<int> place_;  ///< of each column in column_, −1: none
};

/// Calls fill(row, sum) for every row, on all cores.
template <class Fill>
RowMatrix<double> make_rows(std::size_t rows, std::size_t columns, std::size_t media,
                            const Fill& fill) {
  struct Part {
    std::vector<std::uint32_t> length;
    std::vector<int> column;
    std::vector<double> value;
  };
  constexpr std::size_t least = 4096, most_parts = 64;
  const std::size_t range = std::max(least, rows / most_parts + 1);
  std::vector<Part> parts(pieces(rows, range));
  for_pieces(rows, range, [&](std::size_t piece, std::size_t begin, std::size_t end) {
    Part& part = parts[piece];
    RowSum sum(columns, media);
    for (std::size_t row = begin; row < end; ++row) {
      sum.clear();
      fill(row, sum);
      part.length.push_back(static_cast<std::uint32_t>(sum.columns().size()));
      part.column.insert(part.column.end(), sum.columns().begin(), sum.columns().end());
      part.value.insert(part.value.end(), sum.values().begin(), sum.values().end());
    }
  });
  RowPattern pattern;
  RowMatrix<double> all;
  for (Part& part : parts) {
    check(pattern.column.size() + part.column.size() <= UINT32_MAX, "a row matrix is too large");
    for (const std::uint32_t length : part.length) {
      pattern.start.push_back(pattern.start.back() + length);
    }
    pattern.column.insert(pattern.column.end(), part.column.begin(), part.column.end());
    all.value.insert(all.value.end(), part.value.begin(), part.value.end());
    part = {};
  }
  all.pattern = std::make_shared<const RowPattern>(std::move(pattern));
  return all;
}

/// The matrix of one medium with rows and columns exchanged.
template <class T>
RowMatrix<T> transposed(const RowMatrix<T>& matrix, std::size_t columns) {
  const RowPattern& from = *matrix.pattern;
  RowPattern to;
  to.start.assign(columns + 1, 0);
  for (const int column : from.column) ++to.start[static_cast<std::size_t>(column) + 1];
  for (std::size_t c = 0; c < columns; ++c) to.start[c + 1] += to.start[c];
  to.column.resize(from.column.size());
  RowMatrix<T> result;
  result.value.resize(matrix.value.size());
  std::vector<std::uint32_t> next(to.start.begin(), to.start.end() - 1);
  for (std::size_t row = 0; row < from.rows(); ++row) {
    for (std::uint32_t k = from.start[row]; k < from.start[row + 1]; ++k) {
      const std::uint32_t place = next[static_cast<std::size_t>(from.column[k])]++;
      to.column[place] = static_cast<int>(row);
      result.value[place] = matrix.value[k];
    }
  }
  result.pattern = std::make_shared<const RowPattern>(std::move(to));
  return result;
}

/// Calls use(row, sums) with the row's product with x, one sum per lane. `own`: every lane has a
/// medium of its own, and the matrix as many media as there are lanes; else all share the first.
template <std::size_t lanes, bool own, class T, class Field, class Use>
void for_products(const RowMatrix<T>& matrix, const Field* x, const Use& use) {
  const RowPattern& pattern = *matrix.pattern;
  for_ranges(pattern.rows(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      std::array<Field, lanes> sum{};
      for (std::size_t k = pattern.start[row]; k < pattern.start[row + 1]; ++k) {
        const T* value = matrix.value.data() + (own ? k * lanes : k);
        const Field* from = x + static_cast<std::size_t>(pattern.column[k]) * lanes;
        for (std::size_t lane = 0; lane < lanes; ++lane) {
          sum[lane] += static_cast<Field>(value[own ? lane : 0]) * from[lane];
        }
      }
      use(row, sum);
    }
  });
}

}  // namespace kappamu::forward::linear
