#include "core/mesh/polycube.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <tuple>
#include <utility>

#include "core/mesh/edges.h"
#include "core/mesh/lattice_box.h"

namespace kappamu {

using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

bool before(const Vector3i& a, const Vector3i& b) {
  return std::make_tuple(a.z(), a.y(), a.x()) < std::make_tuple(b.z(), b.y(), b.x());
}

void sort_each_once(std::vector<Vector3i>& places) {
  std::sort(places.begin(), places.end(), before);
  places.erase(std::unique(places.begin(), places.end()), places.end());
}

std::vector<Vector3i> corners_of(const std::vector<Vector3i>& cells) {
  std::vector<Vector3i> corners;
  corners.reserve(8 * cells.size());
  for (const Vector3i& cell : cells) {
    for (int b = 0; b < 8; ++b) corners.push_back(cell + lattice_corner(b));
  }
  sort_each_once(corners);
  return corners;
}

std::string in_words(const Vector3i& place) {
  return "(" + std::to_string(place.x()) + ", " + std::to_string(place.y()) + ", " +
         std::to_string(place.z()) + ")";
}

std::size_t pieces_of(const std::vector<Vector3i>& cells, const LatticeBox<int>& number) {
  std::vector<bool> seen(cells.size(), false);
  std::vector<std::size_t> open;
  std::size_t pieces = 0;
  for (std::size_t first = 0; first < cells.size(); ++first) {
    if (seen[first]) continue;
    ++pieces;
    seen[first] = true;
    open.push_back(first);
    while (!open.empty()) {
      const Vector3i cell = cells[open.back()];
      open.pop_back();
      for (int side = 0; side < 6; ++side) {
        const int next = number.at(cell + lattice_side(side));
        if (next == 0 || seen[static_cast<std::size_t>(next - 1)]) continue;
        seen[static_cast<std::size_t>(next - 1)] = true;
        open.push_back(static_cast<std::size_t>(next - 1));
      }
    }
  }
  return pieces;
}

/// Numbers of the cells from 1; 0: no cell.
LatticeBox<int> numbered(const std::vector<Vector3i>& cells) {
  Vector3i low = cells[0], high = cells[0];
  for (const Vector3i& cell : cells) {
    low = low.cwiseMin(cell);
    high = high.cwiseMax(cell);
  }
  LatticeBox<int> number(low - Vector3i::Ones(), high + Vector3i::Ones(), 0);
  for (std::size_t i = 0; i < cells.size(); ++i) number[cells[i]] = static_cast<int>(i) + 1;
  return number;
}

}  // namespace

bool manifold_corner(unsigned filled) {
  // Both the cells that are there and those that are not hang together by faces.
  const auto together = [](unsigned set) {
    if (set == 0) return true;
    unsigned reached = set & ~(set - 1);
    for (int pass = 0; pass < 7; ++pass) {
      for (unsigned b = 0; b < 8; ++b) {
        if ((reached >> b & 1U) == 0) continue;
        reached |= set & (1U << (b ^ 1U) | 1U << (b ^ 2U) | 1U << (b ^ 4U));
      }
    }
    return reached == set;
  };
  return together(filled) && together(~filled & 255U);
}

std::optional<std::string> polycube_problem(const std::vector<Vector3i>& cells) {
  if (cells.empty()) return "has no cells";
  const LatticeBox<int> number = numbered(cells);
  if (pieces_of(cells, number) > 1) return "is in several pieces that share no face";
  for (const Vector3i& corner : corners_of(cells)) {
    unsigned filled = 0;
    for (int b = 0; b < 8; ++b) {
      if (number.at(corner - Vector3i::Ones() + lattice_corner(b)) != 0) filled |= 1U << b;
    }
    if (!manifold_corner(filled)) {
      return "touches itself in an edge or a corner alone at " + in_words(corner);
    }
  }
  return std::nullopt;
}

int genus(const std::vector<Vector3i>& cells) {
  // χ of a solid is half that of its surface, 1 - genus: corners - edges + faces - cells.
  const LatticeBox<int> number = numbered(cells);
  std::int64_t chi =
      static_cast<std::int64_t>(corners_of(cells).size()) - static_cast<std::int64_t>(cells.size());
  for (const Vector3i& cell : cells) {
    for (int axis = 0; axis < 3; ++axis) {
      // A face belongs to the cell above it or, where there is none, to the one below.
      chi += 1 + (number.at(cell + lattice_side(2 * axis + 1)) == 0 ? 1 : 0);
    }
  }
  std::vector<Vector3i> edges;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3i u = Vector3i::Unit((axis + 1) % 3), v = Vector3i::Unit((axis + 2) % 3);
    edges.clear();
    for (const Vector3i& cell : cells) {
      for (const Vector3i& edge :
           {cell, Vector3i(cell + u), Vector3i(cell + v), Vector3i(cell + u + v)}) {
        edges.push_back(edge);
      }
    }
    sort_each_once(edges);
    chi -= static_cast<std::int64_t>(edges.size());
  }
  return static_cast<int>(1 - chi);
}

int genus(const TriangleMesh& mesh) {
  std::set<std::pair<int, int>> edges;
  std::set<int> vertices;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      vertices.insert(t[k]);
      edges.insert(std::minmax(t[k], t[(k + 1) % 3]));
    }
  }
  const auto count = [](const auto& set) { return static_cast<std::int64_t>(set.size()); };
  const std::int64_t chi = count(vertices) - count(edges) + count(mesh.triangles);
  return static_cast<int>((2 - chi) / 2);
}

Polycube lattice_polycube(std::vector<Vector3i> cells, const Vector3d& origin, double spacing) {
  Polycube made;
  made.cells = std::move(cells);
  sort_each_once(made.cells);
  made.corners = corners_of(made.cells);
  for (const Vector3i& corner : made.corners) {
    made.mapped.emplace_back(origin + spacing * corner.cast<double>());
  }
  return made;
}

}  // namespace kappamu
