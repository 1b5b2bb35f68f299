// Polygrids of shapes whose volume and topology are known, and of meshes that admit none.
// Not tested here: real meshes (`kappamu-studies polygrid`).
#include "forward/polygrid/shape/make_polygrid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/mesh/mesh_check.h"
#include "core/mesh/shapes.h"
#include "core/numbers/at.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/shape/layered_lattice.h"
#include "forward/polygrid/shape/place_nodes.h"
#include "tests/sentence.h"

namespace kappamu::forward {
namespace {

using Eigen::Vector3d;

MadePolygrid made(const TriangleMesh& mesh, int cells, double first_layer = 0.1) {
  Progress progress;
  return make_polygrid(mesh, {cells, first_layer}, progress);
}

TEST(MakePolygrid, QualityIsThatAskedFor) {
  const std::vector<std::pair<std::string, TriangleMesh>> shapes{
      {"sphere", sphere_mesh(10.0, 40)},
      {"torus", torus_mesh(10.0, 4.0, 60)},
      {"cylinder", cylinder_mesh(5.0, 16.0, 40)},
      {"box", box_mesh({10.0, 7.0, 4.0}, 20)}};
  for (const auto& [name, mesh] : shapes) {
    const MadePolygrid grid = made(mesh, 2000);
    const PolygridQuality& quality = grid.quality;
    EXPECT_EQ(quality.inverted, 0) << name;
    EXPECT_GE(quality.least_jacobian, 0.2) << name;
    EXPECT_GE(quality.mean_jacobian, 0.85) << name;
    EXPECT_NEAR(quality.cells, 2000, 667) << name;
    EXPECT_NEAR(quality.volume_ratio, 1.0, 0.03) << name;
    EXPECT_LE(quality.largest_gap, 1.0) << name;
    EXPECT_TRUE(grid.warnings.empty()) << name << ": " << grid.warnings[0];
    EXPECT_EQ(genus(surface_of_grid(grid.grid)), name == "torus" ? 1 : 0) << name;
  }
}

TEST(MakePolygrid, VolumeOfASphereConvergesAtOrderTwo) {
  // The faces' corners lie on the sphere, so the error is of the squared edge; cells as 1, 8.
  const TriangleMesh mesh = sphere_mesh(10.0, 120);
  const double coarse = 1.0 - made(mesh, 1000).quality.volume_ratio;
  const double fine = 1.0 - made(mesh, 8000).quality.volume_ratio;
  // Each grid has a polycube of its own, whose cells are not similar.
  constexpr double other_polycube = 0.5;
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, other_polycube);
}

TEST(MakePolygrid, BoundaryNodesLieOnTheSurfaceAndTheFirstLayerBelowThem) {
  const TriangleMesh mesh = sphere_mesh(10.0, 60);
  const Polygrid grid = made(mesh, 2000).grid;
  const double depth = 0.1 * boundary_spacing(grid);
  const ClosestPoint surface(mesh);
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < grid.boundary_node.size(); ++k) {
    EXPECT_LT(surface.from(grid.boundary_node[k]).distance, 1e-12);
    EXPECT_GT(grid.normal[k].dot(grid.boundary_node[k].normalized()), 0.99);
    const Vector3d& node = grid.node[at(grid.boundary_cell[k])];
    EXPECT_NEAR((grid.boundary_node[k] - node).norm(), depth, 1e-9);
    sum += side_area(grid, at(grid.boundary_cell[k]), grid.boundary_side[k]);
  }
  EXPECT_LT(sum.norm(), 1e-9) << "closed: area vectors add up to nothing";
  for (std::size_t i = 0; i < grid.node.size(); ++i) {
    EXPECT_TRUE(place_in_cell(grid, i, grid.node[i])) << i;
  }
}

TEST(MakePolygrid, WithoutAFirstLayerNodesAreInTheMiddle) {
  const Polygrid grid = made(sphere_mesh(10.0, 30), 1000, 0.0).grid;
  for (std::size_t i = 0; i < grid.node.size(); ++i) {
    EXPECT_EQ(grid.node[i], within_cell(grid, i, Vector3d::Constant(0.5)));
  }
}

TEST(MakePolygrid, IsTheSameForEqualInputAndForAnotherUnit) {
  const TriangleMesh mesh = torus_mesh(10.0, 4.0, 40);
  TriangleMesh larger = mesh;
  for (Vector3d& vertex : larger.vertices) vertex *= 1024.0;
  const Polygrid one = made(mesh, 1000).grid, again = made(mesh, 1000).grid,
                 other = made(larger, 1000).grid;
  EXPECT_EQ(one.corner, again.corner);
  EXPECT_EQ(one.cell, other.cell);
  double off = 0.0;
  for (std::size_t c = 0; c < one.corner.size(); ++c) {
    off = std::max(off, (1024.0 * one.corner[c] - other.corner[c]).norm());
  }
  EXPECT_LT(off, 1e-6 * 10240.0);
}

/// The window interrupts it by the next input: steps between reports are short.
TEST(MakePolygrid, CanBeInterruptedAllAlong) {
  struct Until : Progress {
    int left = 0, met = 0;
    void update(const std::string&, double, const std::string&) override {
      if (++met == left) throw Cancelled();
    }
  };
  const TriangleMesh mesh = sphere_mesh(10.0, 20);
  Until never;
  make_polygrid(mesh, {1000, 0.1}, never);
  EXPECT_GT(never.met, 200);  // places of the lattice, and steps of the map
  Until half;
  half.left = never.met / 2;
  EXPECT_THROW(make_polygrid(mesh, {1000, 0.1}, half), Cancelled);
}

TEST(MakePolygrid, KeepsFourHandles) {
  // A slab with four square holes: the surface of a polycube is a mesh as well.
  std::vector<Eigen::Vector3i> cells;
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 9; ++x) {
      if (y != 1 || x % 2 == 0) cells.emplace_back(x, y, 0);
    }
  }
  const Polycube slab = lattice_polycube(cells, Vector3d::Zero(), 3.0);
  const TriangleMesh mesh =
      check_mesh(surface_of_grid(layered_lattice(slab, 0.1).grid), "slab").mesh;
  ASSERT_EQ(genus(mesh), 4);
  const MadePolygrid grid = made(mesh, 3000);
  EXPECT_EQ(grid.quality.inverted, 0);
  EXPECT_GE(grid.quality.least_jacobian, 0.2);
  EXPECT_EQ(genus(surface_of_grid(grid.grid)), 4);
}

TEST(MakePolygrid, ReportsASpikeThinnerThanItsCells) {
  const MadePolygrid grid = made(make_shape("spike", 40.0, 40), 1000);
  EXPECT_EQ(grid.quality.inverted, 0);
  ASSERT_EQ(grid.warnings.size(), 1U);
  EXPECT_NE(grid.warnings[0].find("leaves parts of the object out"), std::string::npos);
}

TEST(MakePolygrid, TakesAPolycubeDrawnByAPerson) {
  // One cell drawn around a sphere, far from its surface.
  const Polycube drawn = lattice_polycube({{0, 0, 0}}, Vector3d(-4.0, -4.0, -4.0), 8.0);
  Progress progress;
  const MadePolygrid grid = make_polygrid(sphere_mesh(10.0, 40), {1500, 0.1, &drawn}, progress);
  EXPECT_EQ(grid.quality.inverted, 0);
  EXPECT_EQ(grid.quality.refinement, 10);
  EXPECT_EQ(grid.quality.cells, 1000 + 600);
  EXPECT_GE(grid.quality.least_jacobian, 0.2);
  const std::string sentence = sentence_of([&] {
    make_polygrid(torus_mesh(10.0, 4.0, 20), {1500, 0.1, &drawn}, progress);
  });
  EXPECT_EQ(sentence, "The polycube has genus 0, the mesh 1; give it as many holes as the object.");
}

TEST(MakePolygrid, RefusesWhatItCannotUseInOneSentence) {
  const TriangleMesh sphere = sphere_mesh(10.0, 20);
  EXPECT_NE(sentence_of([&] { made(sphere, 99); }).find("100 to 4000000 cells, not 99"),
            std::string::npos);
  EXPECT_NE(sentence_of([&] { made(sphere, 1000, 1.5); }).find("first layer"), std::string::npos);
  TriangleMesh open = sphere;
  open.triangles.pop_back();
  EXPECT_NE(sentence_of([&] { made(open, 1000); }).find("closed mesh"), std::string::npos);
  EXPECT_NE(sentence_of([&] { made(turned_inside_out(sphere), 1000); }).find("face in"),
            std::string::npos);
  EXPECT_NE(sentence_of([&] {
              made(joined(sphere, moved(sphere, {30.0, 0.0, 0.0})), 1000);
            }).find("one piece; this one has 2"),
            std::string::npos);
  EXPECT_NE(sentence_of([&] { made({}, 1000); }).find("no triangles"), std::string::npos);
  // A ring so thin that no cells of this number show its hole and its tube.
  const std::string thin = sentence_of([&] { made(torus_mesh(10.0, 0.05, 400), 100); });
  EXPECT_NE(thin.find("take more cells"), std::string::npos) << thin;
}

}  // namespace
}  // namespace kappamu::forward
