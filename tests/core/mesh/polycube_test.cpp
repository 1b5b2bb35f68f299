// Which sets of lattice cells are polycubes, and their genus.
#include "core/mesh/polycube.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/mesh/shapes.h"

namespace kappamu {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

std::vector<Vector3i> block(int nx, int ny, int nz) {
  std::vector<Vector3i> cells;
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) cells.emplace_back(x, y, z);
    }
  }
  return cells;
}

std::vector<Vector3i> without(std::vector<Vector3i> cells, const Vector3i& one) {
  std::erase(cells, one);
  return cells;
}

TEST(PolycubeProblem, BlocksAndRingsAreValid) {
  EXPECT_FALSE(polycube_problem(block(1, 1, 1)));
  EXPECT_FALSE(polycube_problem(block(3, 2, 5)));
  EXPECT_FALSE(polycube_problem(without(block(3, 3, 1), {1, 1, 0})));
}

TEST(PolycubeProblem, CellsThatMeetInAnEdgeOrACornerAreNone) {
  EXPECT_TRUE(polycube_problem({}));
  EXPECT_TRUE(polycube_problem({{0, 0, 0}, {2, 0, 0}}));
  EXPECT_TRUE(polycube_problem({{0, 0, 0}, {1, 1, 0}}));
  // In one piece by other cells, and yet two cells share an edge alone, or a corner.
  const auto edge = polycube_problem({{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0}});
  ASSERT_TRUE(edge);
  EXPECT_NE(edge->find("an edge or a corner alone at (1, 1, "), std::string::npos) << *edge;
  auto corner = without(block(2, 2, 2), {0, 0, 0});
  std::erase(corner, Vector3i(1, 1, 1));
  EXPECT_TRUE(polycube_problem(corner));
}

TEST(ManifoldCorner, IsTheSameForTheComplement) {
  for (unsigned filled = 0; filled < 256; ++filled) {
    EXPECT_EQ(manifold_corner(filled), manifold_corner(~filled & 255U)) << filled;
  }
  EXPECT_TRUE(manifold_corner(0b1));
  EXPECT_FALSE(manifold_corner(0b1001));
  EXPECT_FALSE(manifold_corner(0b10000001));
}

TEST(Genus, CountsHandlesOfPolycubesAndMeshes) {
  EXPECT_EQ(genus(block(2, 3, 4)), 0);
  EXPECT_EQ(genus(without(block(3, 3, 1), {1, 1, 0})), 1);
  auto two = without(block(5, 3, 2), {1, 1, 0});
  for (const Vector3i& hole : {Vector3i(1, 1, 1), Vector3i(3, 1, 0), Vector3i(3, 1, 1)}) {
    std::erase(two, hole);
  }
  EXPECT_EQ(genus(two), 2);
  EXPECT_EQ(genus(sphere_mesh(1.0, 8)), 0);
  EXPECT_EQ(genus(torus_mesh(2.0, 0.5, 12)), 1);
}

TEST(LatticePolycube, MapsEachCornerOnce) {
  std::vector<Vector3i> cells = block(2, 1, 1);
  std::reverse(cells.begin(), cells.end());
  cells.push_back(cells[0]);
  const Polycube made = lattice_polycube(cells, Vector3d(1.0, 2.0, 3.0), 0.5);
  EXPECT_EQ(made.cells, block(2, 1, 1));
  ASSERT_EQ(made.corners.size(), 12U);
  for (std::size_t i = 0; i < made.corners.size(); ++i) {
    EXPECT_EQ(made.mapped[i], Vector3d(1.0, 2.0, 3.0) + 0.5 * made.corners[i].cast<double>());
  }
}

}  // namespace
}  // namespace kappamu
