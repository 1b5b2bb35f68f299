// Links and corners of polycubes with the layer upon them, and what refinement keeps.
#include "forward/polygrid/shape/layered_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "core/mesh/shapes.h"
#include "core/numbers/at.h"
#include "forward/polygrid/cell_geometry.h"

namespace kappamu::forward {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// A ring with a tower on it: convex and concave edges, corners of every kind, a handle.
Polycube ring_with_tower() {
  std::vector<Vector3i> cells;
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x) {
      if (y != 1 || x == 0 || x == 3) cells.emplace_back(x, y, 0);
    }
  }
  cells.emplace_back(0, 0, 1);
  cells.emplace_back(0, 0, 2);
  cells.emplace_back(1, 0, 1);
  return lattice_polycube(cells, Vector3d(0.5, 0.0, -1.0), 2.0);
}

std::set<int> side_of(const Polygrid& grid, int cell, int side) {
  std::set<int> corners;
  for (const int b : side_corners(side)) corners.insert(grid.cell_corners[at(cell)][at(b)]);
  return corners;
}

void expect_linked(const LayeredLattice& lattice) {
  const Polygrid& grid = lattice.grid;
  std::size_t boundary = 0;
  for (int i = 0; i < static_cast<int>(grid.cell.size()); ++i) {
    int outside = 0;
    for (int s = 0; s < 6; ++s) {
      const int next = grid.link[at(i)][at(s)];
      if (next < 0) {
        ++outside;
        ++boundary;
        EXPECT_EQ(grid.boundary_cell[at(~next)], i);
        EXPECT_EQ(grid.boundary_side[at(~next)], s);
        for (const int corner : side_of(grid, i, s)) EXPECT_GE(at(corner), lattice.first_outer());
        continue;
      }
      const auto& back = grid.link[at(next)];
      ASSERT_EQ(std::count(back.begin(), back.end(), i), 1);
      const int t = static_cast<int>(std::find(back.begin(), back.end(), i) - back.begin());
      EXPECT_EQ(side_of(grid, i, s), side_of(grid, next, t)) << "both have the same face";
    }
    EXPECT_LE(outside, 1) << "one boundary node to an interior node, [W] figure 4";
  }
  EXPECT_EQ(boundary, grid.boundary_cell.size());
  for (std::size_t i = 0; i + 1 < grid.cell.size(); ++i) {
    const auto key = [&](std::size_t c) {
      const Vector3i& p = grid.cell[c];
      const auto& links = grid.link[c];
      return std::make_tuple(
          p.z(), p.y(), p.x(),
          (std::find_if(links.begin(), links.end(), [](int l) { return l < 0; }) - links.begin()) %
              6);
    };
    EXPECT_TRUE(key(i) < key(i + 1) || std::get<3>(key(i)) == 0) << "sorted";
  }
}

TEST(LayeredLattice, EveryLinkHasItsWayBackThroughTheSameFace) {
  const LayeredLattice lattice = layered_lattice(ring_with_tower(), 0.5);
  expect_linked(lattice);
  // Every core cell's open faces carry a cell each, and corners double where the surface is.
  EXPECT_EQ(lattice.grid.cell.size(), lattice.core.size() + lattice.grid.boundary_cell.size());
  const auto surface =
      std::count_if(lattice.outer_of.begin(), lattice.outer_of.end(), [](int o) { return o != 0; });
  EXPECT_EQ(lattice.grid.corner.size(),
            lattice.core_corner.size() + static_cast<std::size_t>(surface));
}

TEST(LayeredLattice, SurfaceIsClosedAndOfThePolycubesGenus) {
  const LayeredLattice lattice = layered_lattice(ring_with_tower(), 0.5);
  const TriangleMesh surface = surface_of_grid(lattice.grid);
  EXPECT_EQ(genus(surface), 1);
  double cells = 0.0;
  for (std::size_t i = 0; i < lattice.grid.cell.size(); ++i) cells += cell_volume(lattice.grid, i);
  // Faces whose corners are not in a plane differ from their two triangles.
  constexpr double warped_faces = 0.01;
  EXPECT_NEAR(cells, enclosed_volume(surface), warped_faces * cells);
}

TEST(LayeredLattice, RefinementKeepsTheSurfaceAndHalvesPlaces) {
  const LayeredLattice coarse = layered_lattice(ring_with_tower(), 0.5);
  for (const int factor : {2, 3}) {
    const LayeredLattice fine = refined(coarse, factor);
    expect_linked(fine);
    const auto n = static_cast<std::size_t>(factor);
    EXPECT_EQ(fine.core.size(), n * n * n * coarse.core.size());
    EXPECT_EQ(fine.grid.boundary_cell.size(), n * n * coarse.grid.boundary_cell.size());
    EXPECT_EQ(fine.cells_across, factor);
    double area = 0.0, coarse_area = 0.0;
    for (std::size_t k = 0; k < fine.grid.boundary_cell.size(); ++k) {
      area +=
          side_area(fine.grid, at(fine.grid.boundary_cell[k]), fine.grid.boundary_side[k]).norm();
    }
    for (std::size_t k = 0; k < coarse.grid.boundary_cell.size(); ++k) {
      coarse_area +=
          side_area(coarse.grid, at(coarse.grid.boundary_cell[k]), coarse.grid.boundary_side[k])
              .norm();
    }
    EXPECT_NEAR(area, coarse_area, 0.01 * coarse_area);
  }
  // The rule by which coarser levels are found (polygrid.h).
  const auto keys = [](const Polygrid& grid, int shift) {
    std::set<std::tuple<int, int, int, int>> found;
    for (std::size_t i = 0; i < grid.cell.size(); ++i) {
      int outer = 6;
      for (int s = 0; s < 6; ++s) outer = grid.link[i][at(s)] < 0 ? s : outer;
      found.emplace(grid.cell[i].x() >> shift, grid.cell[i].y() >> shift, grid.cell[i].z() >> shift,
                    outer);
    }
    return found;
  };
  EXPECT_EQ(keys(refined(coarse, 2).grid, 1), keys(coarse.grid, 0));
}

}  // namespace
}  // namespace kappamu::forward
