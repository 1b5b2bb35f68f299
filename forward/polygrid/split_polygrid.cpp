#include "forward/polygrid/split_polygrid.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/parallel.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/closest_point.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using Corners = std::array<int, 8>;
using Four = std::array<int, 4>;

Four sorted_side(const Corners& corners, int side) {
  Four key{};
  for (std::size_t i = 0; i < 4; ++i) {
    key[i] = corners[static_cast<std::size_t>(side_corners(side)[i])];
  }
  std::sort(key.begin(), key.end());
  return key;
}

void sort_by_place(std::vector<Vector3i>& cell, std::vector<Corners>& cell_corners) {
  std::vector<std::size_t> order(cell.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tuple(cell[a][2], cell[a][1], cell[a][0]) <
           std::tuple(cell[b][2], cell[b][1], cell[b][0]);
  });
  std::vector<Vector3i> places;
  std::vector<Corners> corners;
  for (const std::size_t k : order) {
    places.push_back(cell[k]);
    corners.push_back(cell_corners[k]);
  }
  cell = std::move(places);
  cell_corners = std::move(corners);
}

/// Numbers corners along the lines of the lattice, so that those of a line follow each other and
/// its neighbours lie alike for all; lines in the order of their first corners' places, which are
/// those in the first cell that has them.
void number_by_lines(const std::vector<Vector3i>& cell, std::vector<Corners>& cell_corners,
                     std::vector<Vector3d>& corner) {
  using Lexical = std::tuple<int, int, int>;
  // Where sides are bent around an edge a corner may have two neighbours: the first is taken.
  std::vector<int> next(corner.size(), -1);
  std::vector<char> met(corner.size(), 0), follows(corner.size(), 0);
  std::vector<std::pair<Lexical, int>> order;
  for (std::size_t k = 0; k < cell.size(); ++k) {
    for (int bits = 0; bits < 8; ++bits) {
      const int c = cell_corners[k][static_cast<std::size_t>(bits)];
      const auto from = static_cast<std::size_t>(c);
      if ((bits & 1) == 0) {
        const int d = cell_corners[k][static_cast<std::size_t>(bits | 1)];
        if (next[from] < 0 && c != d && std::exchange(follows[static_cast<std::size_t>(d)], 1) == 0)
          next[from] = d;
      }
      if (std::exchange(met[from], 1) != 0) continue;
      const Vector3i at = cell[k] + Vector3i(bits & 1, bits >> 1 & 1, bits >> 2 & 1);
      order.emplace_back(Lexical(at[2], at[1], at[0]), c);
    }
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<int> number(corner.size(), -1);
  std::vector<Vector3d> sorted;
  const auto take_line = [&](int from) {
    for (int c = from; c >= 0 && number[static_cast<std::size_t>(c)] < 0;
         c = next[static_cast<std::size_t>(c)]) {
      number[static_cast<std::size_t>(c)] = static_cast<int>(sorted.size());
      sorted.push_back(corner[static_cast<std::size_t>(c)]);
    }
  };
  for (const auto& [place, c] : order) {
    if (follows[static_cast<std::size_t>(c)] == 0) take_line(c);
  }
  for (const auto& [place, c] : order) take_line(c);  // lines that are closed, if any
  for (Corners& corners : cell_corners) {
    for (int& c : corners) c = number[static_cast<std::size_t>(c)];
  }
  corner = std::move(sorted);
}

/// The points of a cell's 3 × 3 × 3 corners of its children, each by the corners of the cell that
/// it is the middle of: two of an edge, four of a side, all of the cell; sorted, padded by the
/// last.
using Middle = std::array<int, 8>;
Middle middle_of(const Corners& corners, const Vector3i& at) {
  Middle key{};
  std::size_t count = 0;
  for (int c = 0; c < 8; ++c) {
    bool of = true;
    for (int a = 0; a < 3; ++a) of = of && (at[a] == 1 || at[a] == 2 * (c >> a & 1));
    if (of) key[count++] = corners[static_cast<std::size_t>(c)];
  }
  for (std::size_t i = count; i < key.size(); ++i)
    key[i] = *std::max_element(key.begin(), key.end());
  std::sort(key.begin(), key.end());
  return key;
}

Vector3d position_of(const Middle& key, const std::vector<Vector3d>& corner) {
  Vector3d sum = Vector3d::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < key.size(); ++i) {
    if (i > 0 && key[i] == key[i - 1]) break;
    sum += corner[static_cast<std::size_t>(key[i])];
    count += 1.0;
  }
  return sum / count;
}

/// Moves corners of the boundary to the mesh, and those of cells that do not bear it back.
void to_surface(Polygrid& grid, const TriangleMesh& mesh) {
  std::vector<int> boundary;
  std::vector<char> on_boundary(grid.corner.size(), 0);
  for (std::size_t b = 0; b < grid.boundary_cell.size(); ++b) {
    for (const int c : boundary_corners(grid, b)) {
      const auto corner = static_cast<std::size_t>(c);
      if (on_boundary[corner] == 0) boundary.push_back(static_cast<int>(corner));
      on_boundary[corner] = 1;
    }
  }
  const ClosestPoint surface(mesh);
  const auto upright = [&](std::size_t cell) { return scaled_jacobian(grid, cell) > 0.0; };
  std::vector<char> was_upright(grid.cell.size());
  for (std::size_t k = 0; k < grid.cell.size(); ++k) was_upright[k] = upright(k);
  const std::vector<Vector3d> before = grid.corner;
  for_ranges(boundary.size(), [&](std::size_t begin, std::size_t end) {
    int near = 0;
    for (std::size_t k = begin; k < end; ++k) {
      Vector3d& corner = grid.corner[static_cast<std::size_t>(boundary[k])];
      const ClosestPoint::Found found = surface.from(corner, near);
      near = found.triangle;
      corner = found.point;
    }
  });
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t k = 0; k < grid.cell.size(); ++k) {
      if (was_upright[k] == 0 || upright(k)) continue;
      for (const int c : grid.cell_corners[k]) {
        const auto corner = static_cast<std::size_t>(c);
        changed = changed || grid.corner[corner] != before[corner];
        grid.corner[corner] = before[corner];
      }
    }
  }
}

void place_nodes(Polygrid& grid) {
  grid.node.clear();
  for (std::size_t k = 0; k < grid.cell.size(); ++k) {
    grid.node.push_back(within_cell(grid, k, Vector3d::Constant(0.5)));
  }
  grid.boundary_node.clear();
  grid.normal.clear();
  grid.area.clear();
  for (std::size_t b = 0; b < grid.boundary_cell.size(); ++b) {
    const auto cell = static_cast<std::size_t>(grid.boundary_cell[b]);
    const Vector3d area = side_area(grid, cell, grid.boundary_side[b]);
    grid.boundary_node.push_back(side_centre(grid, cell, grid.boundary_side[b]));
    grid.normal.push_back(area.normalized());
    grid.area.push_back(area.norm());
  }
}

}  // namespace

Polygrid linked(std::vector<Vector3i> cell, std::vector<Corners> cell_corners,
                std::vector<Vector3d> corner) {
  sort_by_place(cell, cell_corners);
  number_by_lines(cell, cell_corners, corner);
  Polygrid grid;
  grid.cell = std::move(cell);
  grid.cell_corners = std::move(cell_corners);
  grid.corner = std::move(corner);
  std::vector<std::pair<Four, int>> sides;
  sides.reserve(6 * grid.cell.size());
  for (std::size_t k = 0; k < grid.cell.size(); ++k) {
    for (int side = 0; side < 6; ++side) {
      sides.emplace_back(sorted_side(grid.cell_corners[k], side), static_cast<int>(6 * k) + side);
    }
  }
  std::sort(sides.begin(), sides.end());
  constexpr int none = std::numeric_limits<int>::max();
  grid.link.assign(grid.cell.size(), {none, none, none, none, none, none});
  const auto link = [&](int at) -> int& {
    return grid.link[static_cast<std::size_t>(at / 6)][static_cast<std::size_t>(at % 6)];
  };
  for (std::size_t s = 0; s + 1 < sides.size(); ++s) {
    if (sides[s].first != sides[s + 1].first) continue;
    link(sides[s].second) = sides[s + 1].second / 6;
    link(sides[s + 1].second) = sides[s].second / 6;
  }
  for (std::size_t k = 0; k < grid.cell.size(); ++k) {
    for (std::size_t side = 0; side < 6; ++side) {
      if (grid.link[k][side] != none) continue;
      grid.link[k][side] = ~static_cast<int>(grid.boundary_cell.size());
      grid.boundary_cell.push_back(static_cast<int>(k));
      grid.boundary_side.push_back(static_cast<int>(side));
    }
  }
  place_nodes(grid);
  return grid;
}

Polygrid split(const Polygrid& grid, const TriangleMesh& mesh) {
  // Every child's corners by what they are the middle of; equal ones are one corner.
  std::vector<std::pair<Middle, std::size_t>> middles;  // with 27·cell + place
  middles.reserve(27 * grid.cell.size());
  for (std::size_t k = 0; k < grid.cell.size(); ++k) {
    for (int i = 0; i < 27; ++i) {
      middles.emplace_back(middle_of(grid.cell_corners[k], Vector3i(i % 3, i / 3 % 3, i / 9)),
                           27 * k + static_cast<std::size_t>(i));
    }
  }
  std::sort(middles.begin(), middles.end());
  std::vector<int> number(middles.size());
  std::vector<Vector3d> corner;
  for (std::size_t m = 0; m < middles.size(); ++m) {
    if (m == 0 || middles[m].first != middles[m - 1].first) {
      corner.push_back(position_of(middles[m].first, grid.corner));
    }
    number[middles[m].second] = static_cast<int>(corner.size()) - 1;
  }
  std::vector<Vector3i> cell;
  std::vector<Corners> cell_corners;
  for (std::size_t k = 0; k < grid.cell.size(); ++k) {
    for (int child = 0; child < 8; ++child) {
      const Vector3i octant(child & 1, child >> 1 & 1, child >> 2 & 1);
      Corners corners{};
      for (int c = 0; c < 8; ++c) {
        const Vector3i at = octant + Vector3i(c & 1, c >> 1 & 1, c >> 2 & 1);
        corners[static_cast<std::size_t>(c)] =
            number[27 * k + static_cast<std::size_t>(at[0] + 3 * at[1] + 9 * at[2])];
      }
      cell.push_back(2 * grid.cell[k] + octant);
      cell_corners.push_back(corners);
    }
  }
  Polygrid result = linked(std::move(cell), std::move(cell_corners), std::move(corner));
  to_surface(result, mesh);
  place_nodes(result);
  return result;
}

}  // namespace kappamu::forward::polygrid
