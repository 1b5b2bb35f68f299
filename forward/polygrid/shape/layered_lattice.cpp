#include "forward/polygrid/shape/layered_lattice.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/mesh/lattice_box.h"
#include "core/numbers/at.h"
#include "forward/polygrid/cell_geometry.h"

namespace kappamu::forward {

using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

/// Numbers from 1 of what lies in a box of lattice places; 0: nothing.
LatticeBox<int> numbered(const std::vector<Vector3i>& places) {
  Vector3i low = places[0], high = places[0];
  for (const Vector3i& place : places) {
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  }
  LatticeBox<int> number(low, high, 0);
  for (std::size_t i = 0; i < places.size(); ++i) number[places[i]] = static_cast<int>(i) + 1;
  return number;
}

/// A face of the core's surface: core cell and its side.
struct SurfaceFace {
  int core = 0, side = 0;
};

class Builder {
 public:
  Builder(std::vector<Vector3i> core, std::vector<Vector3i> core_corner)
      : corner_number_(numbered(core_corner)), core_number_(numbered(core)) {
    made_.core = std::move(core);
    made_.core_corner = std::move(core_corner);
    find_surface();
    sort_cells();
    link_cells();
  }
  LayeredLattice take() { return std::move(made_); }

 private:
  int core_at(const Vector3i& place) const { return core_number_.at(place) - 1; }
  int corner_at(const Vector3i& place) const { return corner_number_.at(place) - 1; }

  void find_surface() {
    face_of_.assign(6 * made_.core.size(), 0);
    made_.outer_of.assign(made_.core_corner.size(), 0);
    for (std::size_t c = 0; c < made_.core.size(); ++c) {
      for (int side = 0; side < 6; ++side) {
        if (core_at(made_.core[c] + lattice_side(side)) >= 0) continue;
        faces_.push_back({static_cast<int>(c), side});
        for (int b = 0; b < 8; ++b) {
          if ((b >> (side / 2) & 1) != side % 2) continue;
          made_.outer_of[at(corner_at(made_.core[c] + lattice_corner(b)))] = 1;
        }
      }
    }
    int next = static_cast<int>(made_.core_corner.size());
    for (int& outer : made_.outer_of) outer = outer == 0 ? 0 : next++;
    made_.grid.corner.assign(at(next), Vector3d::Zero());
  }

  void sort_cells() {
    // Cells by place, then the layer's by their outer side; `side` is -1 within the core.
    struct Cell {
      Vector3i place;
      int core, side;
    };
    std::vector<Cell> cells;
    for (std::size_t c = 0; c < made_.core.size(); ++c) {
      cells.push_back({made_.core[c], static_cast<int>(c), -1});
    }
    for (const SurfaceFace& face : faces_) {
      cells.push_back({made_.core[at(face.core)] + lattice_side(face.side), face.core, face.side});
    }
    std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
      for (const int axis : {2, 1, 0}) {
        if (a.place[axis] != b.place[axis]) return a.place[axis] < b.place[axis];
      }
      return a.side < b.side;
    });
    node_of_core_.resize(made_.core.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const Cell& cell = cells[i];
      made_.grid.cell.push_back(cell.place);
      if (cell.side < 0) {
        node_of_core_[at(cell.core)] = static_cast<int>(i);
      } else {
        face_of_[6 * at(cell.core) + at(cell.side)] = static_cast<int>(i);
      }
      cells_.push_back({cell.core, cell.side});
    }
  }

  /// The cell of the layer beside that upon `side` of `core`, across its side `towards`.
  int beside(int core, int side, int towards) const {
    const Vector3i place = made_.core[at(core)];
    const Vector3i along = place + lattice_side(towards);
    const int above = core_at(along + lattice_side(side));
    if (above >= 0) return face_of_[6 * at(above) + at(towards ^ 1)];  // concave edge
    const int next = core_at(along);
    if (next >= 0) return face_of_[6 * at(next) + at(side)];
    return face_of_[6 * at(core) + at(towards)];  // convex edge
  }

  void link_cells() {
    Polygrid& grid = made_.grid;
    grid.cell_corners.resize(cells_.size());
    grid.link.resize(cells_.size());
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const auto [core, side] = cells_[i];
      if (side < 0) {
        for (int b = 0; b < 8; ++b) {
          grid.cell_corners[i][at(b)] = corner_at(made_.core[at(core)] + lattice_corner(b));
        }
        for (int s = 0; s < 6; ++s) {
          const int next = core_at(made_.core[at(core)] + lattice_side(s));
          grid.link[i][at(s)] =
              next >= 0 ? node_of_core_[at(next)] : face_of_[6 * at(core) + at(s)];
        }
        continue;
      }
      const int axis = side / 2;
      for (int b = 0; b < 8; ++b) {
        const bool outer = (b >> axis & 1) == side % 2;
        // The corner of the core's face, at the same place along the others axes.
        const int on_face = (b & ~(1 << axis)) | (side % 2) << axis;
        const int inner = corner_at(made_.core[at(core)] + lattice_corner(on_face));
        grid.cell_corners[i][at(b)] = outer ? made_.outer_of[at(inner)] : inner;
      }
      for (int s = 0; s < 6; ++s) {
        if (s == side) {
          grid.link[i][at(s)] = ~static_cast<int>(grid.boundary_cell.size());
          grid.boundary_cell.push_back(static_cast<int>(i));
          grid.boundary_side.push_back(side);
        } else if (s == (side ^ 1)) {
          grid.link[i][at(s)] = node_of_core_[at(core)];
        } else {
          grid.link[i][at(s)] = beside(core, side, s);
        }
      }
    }
  }

  LayeredLattice made_;
  LatticeBox<int> corner_number_, core_number_;
  std::vector<SurfaceFace> faces_, cells_;
  std::vector<int> face_of_;       ///< per core cell and side: the cell of the layer upon it
  std::vector<int> node_of_core_;  ///< per core cell: its place in the grid
};

}  // namespace

LayeredLattice layered_lattice(const Polycube& polycube, double thickness) {
  LayeredLattice made = Builder(polycube.cells, polycube.corners).take();
  Polygrid& grid = made.grid;
  std::copy(polycube.mapped.begin(), polycube.mapped.end(), grid.corner.begin());
  std::vector<Vector3d> normal(grid.corner.size(), Vector3d::Zero());
  double edges = 0.0;
  for (std::size_t k = 0; k < grid.boundary_cell.size(); ++k) {
    const auto& c = grid.cell_corners[at(grid.boundary_cell[k])];
    const int side = grid.boundary_side[k];
    const auto inner = side_corners(side ^ 1);
    const auto on = [&](std::size_t i) -> const Vector3d& {
      return grid.corner[at(c[at(inner[i])])];
    };
    const Vector3d area = -0.5 * (on(2) - on(0)).cross(on(3) - on(1));
    edges += std::sqrt(area.norm());
    for (const int b : inner) normal[at(c[at(b)])] += area;
  }
  const double length = thickness * edges / static_cast<double>(grid.boundary_cell.size());
  for (std::size_t i = 0; i < made.first_outer(); ++i) {
    if (made.outer_of[i] == 0) continue;
    grid.corner[at(made.outer_of[i])] = grid.corner[i] + length * normal[i].stableNormalized();
  }
  return made;
}

LayeredLattice refined(const LayeredLattice& coarse, int factor) {
  std::vector<Vector3i> core;
  for (const Vector3i& cell : coarse.core) {
    for (int z = 0; z < factor; ++z) {
      for (int y = 0; y < factor; ++y) {
        for (int x = 0; x < factor; ++x) core.emplace_back(factor * cell + Vector3i(x, y, z));
      }
    }
  }
  Polycube fine = lattice_polycube(std::move(core), Vector3d::Zero(), 1.0);
  LayeredLattice made = Builder(fine.cells, fine.corners).take();
  made.cells_across = factor * coarse.cells_across;
  const LatticeBox<int> number = numbered(made.core_corner);
  const double f = factor;
  const Polygrid& grid = coarse.grid;
  const auto corner_at = [&](const Vector3i& place) { return at(number.at(place) - 1); };
  // First the core, then the layer, whose inner face moves outwards with the core's surface.
  for (const bool layer : {false, true}) {
    for (std::size_t i = 0; i < grid.cell.size(); ++i) {
      const auto outside =
          std::find_if(grid.link[i].begin(), grid.link[i].end(), [](int link) { return link < 0; });
      if ((outside != grid.link[i].end()) != layer) continue;
      const int side = static_cast<int>(outside - grid.link[i].begin()), axis = side / 2;
      for (int z = 0; z <= factor; ++z) {
        for (int y = 0; y <= factor; ++y) {
          for (int x = 0; x <= factor; ++x) {
            const Vector3i step(x, y, z);
            Vector3d u = step.cast<double>() / f;
            if (!layer) {
              made.grid.corner[corner_at(factor * grid.cell[i] + step)] = within_cell(grid, i, u);
              continue;
            }
            const int inner = side % 2 == 0 ? factor : 0;
            if (step[axis] != inner) continue;
            const std::size_t c = corner_at(factor * grid.cell[i] + step);
            u[axis] = side % 2 == 0 ? 0.0 : 1.0;
            const Vector3d top = within_cell(grid, i, u);
            u[axis] = side % 2 == 0 ? 1.0 / f : 1.0 - 1.0 / f;
            made.grid.corner[c] = within_cell(grid, i, u);
            made.grid.corner[at(made.outer_of[c])] = top;
          }
        }
      }
    }
  }
  return made;
}

}  // namespace kappamu::forward
