#include "forward/polygrid/equations/equations.h"

#include <algorithm>

#include "core/parallel.h"

namespace kappamu::forward::polygrid {

namespace {

/// Place of a column within its row.
std::size_t place_in_row(const Pattern& pattern, std::size_t row, int column) {
  const auto begin = pattern.column.begin() + pattern.start[row];
  const auto end = pattern.column.begin() + pattern.start[row + 1];
  return static_cast<std::size_t>(std::lower_bound(begin, end, column) - begin);
}

/// Of `columns` those from `first` on.
void append_row(Pattern& pattern, std::vector<int>& columns, int first) {
  std::erase_if(columns, [&](int column) { return column < first; });
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  pattern.column.insert(pattern.column.end(), columns.begin(), columns.end());
  pattern.start.push_back(static_cast<int>(pattern.column.size()));
}

}  // namespace

Equations::Equations(const Polygrid& grid, double A) : A_(A) {
  const std::size_t cells = grid.cell.size(), corners = grid.corner.size();
  integrals_.resize(cells);
  for_ranges(cells, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) integrals_[k] = cell_integrals(corners_of(grid, k));
  });

  slot_start_.assign(corners + 1, 0);
  place_.assign(corners, Eigen::Vector3i::Zero());
  for (const auto& of_cell : grid.cell_corners) {
    for (const int corner : of_cell) ++slot_start_[static_cast<std::size_t>(corner) + 1];
  }
  for (std::size_t i = 0; i < corners; ++i) slot_start_[i + 1] += slot_start_[i];
  slot_.resize(8 * cells);
  std::vector<int> next(slot_start_.begin(), slot_start_.end() - 1);
  for (std::size_t k = 0; k < cells; ++k) {
    for (int c = 0; c < 8; ++c) {
      const auto corner =
          static_cast<std::size_t>(grid.cell_corners[k][static_cast<std::size_t>(c)]);
      if (next[corner] == slot_start_[corner]) {
        place_[corner] = grid.cell[k] + Eigen::Vector3i(c & 1, c >> 1 & 1, c >> 2 & 1);
      }
      slot_[static_cast<std::size_t>(next[corner]++)] = static_cast<int>(8 * k) + c;
    }
  }
  std::vector<int> row, linked;
  for (std::size_t i = 0; i < corners; ++i) {
    row.clear();
    linked.clear();
    for (int s = slot_start_[i]; s < slot_start_[i + 1]; ++s) {
      const int slot = slot_[static_cast<std::size_t>(s)];
      const auto& others = grid.cell_corners[static_cast<std::size_t>(slot / 8)];
      row.insert(row.end(), others.begin(), others.end());
      for (int a = 0; a < 3; ++a) {
        linked.push_back(others[static_cast<std::size_t>((slot & 7) ^ 1 << a)]);
      }
    }
    append_row(matrix_, row, static_cast<int>(i));
    append_row(links_, linked, static_cast<int>(i) + 1);
  }
  in_row_.resize(slot_.size());
  in_links_.resize(slot_.size());
  for (std::size_t i = 0; i < corners; ++i) {
    for (int s = slot_start_[i]; s < slot_start_[i + 1]; ++s) {
      const auto at = static_cast<std::size_t>(s);
      const auto& others = grid.cell_corners[static_cast<std::size_t>(slot_[at] / 8)];
      const auto place = [&](const Pattern& pattern, int other) {
        return other < static_cast<int>(i)
                   ? elsewhere
                   : static_cast<std::uint8_t>(place_in_row(pattern, i, other));
      };
      for (std::size_t c = 0; c < 8; ++c) in_row_[at][c] = place(matrix_, others[c]);
      for (std::size_t a = 0; a < 3; ++a) {
        in_links_[at][a] =
            place(links_, others[static_cast<std::size_t>((slot_[at] & 7) ^ 1 << a)]);
      }
    }
  }

  boundary_.assign(matrix_.column.size(), 0.0);
  boundary_share_.assign(corners, 0.0);
  for (std::size_t b = 0; b < grid.boundary_cell.size(); ++b) {
    const std::array<int, 4> of_side = boundary_corners(grid, b);
    std::array<std::size_t, 4> corner{};
    std::array<Eigen::Vector3d, 4> at;
    for (std::size_t i = 0; i < 4; ++i) {
      corner[i] = static_cast<std::size_t>(of_side[i]);
      at[i] = grid.corner[corner[i]];
    }
    const SideMass mass = side_mass(at);
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        boundary_share_[corner[i]] += mass[i][j];
        if (corner[j] < corner[i]) continue;
        const std::size_t place = place_in_row(matrix_, corner[i], static_cast<int>(corner[j]));
        boundary_[static_cast<std::size_t>(matrix_.start[corner[i]]) + place] +=
            mass[i][j] / (2.0 * A);
      }
    }
  }
}

void Equations::make_row(std::size_t i, std::span<const Coefficients> of_cell,
                         MediumValues& values) const {
  double* row = values.value.data() + matrix_.start[i];
  double* linked = values.link.data() + links_.start[i];
  double absorption = 0.0;
  std::copy(boundary_.begin() + matrix_.start[i], boundary_.begin() + matrix_.start[i + 1], row);
  std::fill(linked, linked + links_.start[i + 1] - links_.start[i], 0.0);
  for (int s = slot_start_[i]; s < slot_start_[i + 1]; ++s) {
    const auto at = static_cast<std::size_t>(s);
    const auto cell = static_cast<std::size_t>(slot_[at] / 8);
    const auto mine = static_cast<std::size_t>(slot_[at] % 8);
    const CellIntegrals& integrals = integrals_[cell];
    const auto [kappa, mu] = of_cell[cell];
    for (std::size_t c = 0; c < 8; ++c) {
      const std::size_t entry = linear::Element::place(mine, c);
      const double absorbed = mu * integrals.mass.entry[entry];
      absorption += absorbed;
      if (in_row_[at][c] == elsewhere) continue;
      row[in_row_[at][c]] += kappa * integrals.stiffness.entry[entry] + absorbed;
    }
    for (std::size_t a = 0; a < 3; ++a) {
      if (in_links_[at][a] != elsewhere) linked[in_links_[at][a]] += kappa * integrals.edge[a];
    }
  }
  values.leak[i] = boundary_share_[i] / (2.0 * A_) + absorption;
  values.absorption[i] = absorption;
}

MediumValues Equations::values(std::span<const Coefficients> of_cell) const {
  MediumValues result;
  result.value.resize(matrix_.column.size());
  result.link.resize(links_.column.size());
  result.leak.resize(unknowns());
  result.absorption.resize(unknowns());
  for_ranges(unknowns(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) make_row(i, of_cell, result);
  });
  return result;
}

void Equations::renew(std::span<const Coefficients> of_cell, std::span<const int> rows,
                      MediumValues& values) const {
  for_ranges(rows.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      make_row(static_cast<std::size_t>(rows[k]), of_cell, values);
    }
  });
}

}  // namespace kappamu::forward::polygrid
