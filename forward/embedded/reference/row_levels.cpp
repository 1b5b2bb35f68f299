#include "forward/embedded/reference/row_levels.h"

#include <algorithm>

namespace kappamu::forward::embedded {

namespace {

/// A row under construction: some tens of entries.
class RowSum {
 public:
  explicit RowSum(std::size_t columns) : place_(columns, -1) {}
  void clear() {
    for (const auto& entry : entries_) place_[static_cast<std::size_t>(entry.first)] = -1;
    entries_.clear();
  }
  void add(int column, double value) {
    int& place = place_[static_cast<std::size_t>(column)];
    if (place < 0) {
      place = static_cast<int>(entries_.size());
      entries_.emplace_back(column, 0.0);
    }
    entries_[static_cast<std::size_t>(place)].second += value;
  }
  const std::vector<std::pair<int, double>>& entries() const { return entries_; }

 private:
  std::vector<std::pair<int, double>> entries_;
  std::vector<int> place_;  ///< of each column in entries_
};

/// Rows filled from parts that are made independently.
template <class Fill>
SparseRows<double> make_rows(std::size_t rows, std::size_t columns, const Fill& fill) {
  constexpr std::size_t range = 4096;
  const std::size_t parts = (rows + range - 1) / range;
  std::vector<SparseRows<double>> part(parts);
  for_rows(static_cast<int>(parts), [&](int p) {
    SparseRows<double>& mine = part[static_cast<std::size_t>(p)];
    const std::size_t begin = static_cast<std::size_t>(p) * range;
    RowSum row(columns);
    for (std::size_t i = begin; i < std::min(rows, begin + range); ++i) {
      row.clear();
      fill(i, row);
      for (const auto& [column, value] : row.entries()) {
        mine.column.push_back(column);
        mine.value.push_back(value);
      }
      mine.start.push_back(mine.column.size());
    }
  });
  SparseRows<double> all;
  for (const SparseRows<double>& mine : part) {
    const std::size_t before = all.column.size();
    for (std::size_t i = 1; i < mine.start.size(); ++i) all.start.push_back(before + mine.start[i]);
    all.column.insert(all.column.end(), mine.column.begin(), mine.column.end());
    all.value.insert(all.value.end(), mine.value.begin(), mine.value.end());
  }
  return all;
}

SparseRows<double> assembled(const NodeSpace& space, const Elements& elements,
                             std::size_t channel) {
  const Incidence incidence(space);
  return make_rows(space.unknowns(), space.unknowns(), [&](std::size_t u, RowSum& row) {
    for (int k = incidence.start[u]; k < incidence.start[u + 1]; ++k) {
      const auto slot = static_cast<std::size_t>(incidence.slot[static_cast<std::size_t>(k)]);
      const std::size_t cube = slot / 8, i = slot % 8;
      const double weight = NodeSpace::weight(space.parts(cube, i));
      const Element& element = elements.of(cube, channel);
      for (std::size_t j = 0; j < 8; ++j) {
        const auto parts = space.parts(cube, j);
        const double value = weight * NodeSpace::weight(parts) * element(i, j);
        for (const int column : parts) row.add(column, value);
      }
    }
  });
}

SparseRows<float> rounded(const SparseRows<double>& matrix) {
  SparseRows<float> result;
  result.start = matrix.start;
  result.column = matrix.column;
  result.value.assign(matrix.value.begin(), matrix.value.end());
  return result;
}

/// Values of coarse functions at the fine unknowns.
SparseRows<double> interpolation(const NodeSpace& fine, const NodeSpace& coarse,
                                 const Coarser& coarser) {
  const std::vector<int> owner = owner_slots(fine);
  return make_rows(fine.unknowns(), coarse.unknowns(), [&](std::size_t u, RowSum& row) {
    for_coarser_parts(coarser, coarse, owner[u],
                      [&](int column, double weight) { row.add(column, weight); });
  });
}

}  // namespace

RowLevels make_row_levels(const Levels& levels, std::size_t channel, std::size_t first) {
  RowLevels result{
      std::span(levels.level).subspan(first), levels.coarsest[channel], channel, {}, {}};
  for (std::size_t l = 0; l < result.from.size(); ++l) {
    const Level& from = result.from[l];
    RowLevel& level = result.level.emplace_back();
    if (l > 0 && l + 1 == result.from.size()) break;
    SparseRows<double> matrix = assembled(from.space, from.elements, channel);
    level.matrix = rounded(matrix);
    if (l == 0) result.matrix = std::move(matrix);
    if (l + 1 == result.from.size()) break;
    const NodeSpace& coarse = result.from[l + 1].space;
    level.interpolation = rounded(interpolation(from.space, coarse, from.coarser));
    level.restriction = transposed(level.interpolation, coarse.unknowns());
  }
  return result;
}

}  // namespace kappamu::forward::embedded
