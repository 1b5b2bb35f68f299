// Cut cubes against the mesh they come from. What the solver makes of them: embedded_order_test.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "embedded_test_tools.h"
#include "forward/bodies.h"
#include "forward/embedded/geometry/cut_mesh.h"
#include "forward/embedded/refinement.h"

namespace kappamu::forward::embedded {
namespace {

/// Rounding of sums over some thousand cubes.
constexpr double rounding = 1e-11;

CutMesh cut_at(const TriangleMesh& mesh, int level) {
  Octree tree(mesh);
  tree.refine_surface(level);
  return cut_mesh(tree, mesh, *make_caster(mesh));
}

double volume(const CutMesh& mesh) {
  double sum = 0.0;
  for (std::size_t k = 0; k < mesh.cubes.size(); ++k) {
    sum += mesh.fraction(k) * std::pow(mesh.h(k), 3);
  }
  return sum;
}

double area(const CutMesh& mesh) {
  double sum = 0.0;
  for (const auto& piece : mesh.pieces) {
    sum += std::accumulate(piece.weight.begin(), piece.weight.end(), 0.0);
  }
  return sum;
}

/// A cube with a cubic void that shares no plane with it.
TriangleMesh box_with_void() {
  Eigen::Affine3d inner = Eigen::Affine3d::Identity();
  inner.translate(Eigen::Vector3d(3.1, 2.9, 3.3));
  return joined(box({10.0, 10.0, 10.0}, 1), transformed(box({4.0, 4.0, 4.0}, 1), inner), true);
}

TEST(EmbeddedGeometry, CubesSumToVolumeAndArea) {
  Eigen::Affine3d turn = Eigen::Affine3d::Identity();
  turn.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  for (const TriangleMesh& mesh : {icosphere(5.0, 3, {0.1, 0.2, 0.3}), box({10.0, 7.0, 4.0}, 2),
                                   transformed(box({10.0, 7.0, 4.0}, 1), turn), box_with_void(),
                                   transformed(box({20.0, 20.0, 0.01}, 3), turn)}) {
    for (const int level : {0, 2, 4}) {
      const CutMesh cut = cut_at(mesh, level);
      const Surface surface = surface_of(mesh);
      const double whole = std::accumulate(surface.area.begin(), surface.area.end(), 0.0);
      EXPECT_NEAR(volume(cut) / enclosed_volume(mesh), 1.0, 1e3 * rounding) << level;
      EXPECT_NEAR(area(cut) / whole, 1.0, 1e-6) << level;  // weights are single precision
      for (std::size_t k = 0; k < cut.cubes.size(); ++k) {
        ASSERT_GE(cut.fraction(k), 0.0);
        ASSERT_LE(cut.fraction(k), 1.0 + rounding);
      }
    }
  }
}

TEST(EmbeddedGeometry, MomentsOfACutCubeAreExact) {
  // The wedge x + z < 1 of the unit cube.
  CutCell wedge;
  wedge.add(0, {Eigen::Vector3d(2.0, -9.0, -1.0), Eigen::Vector3d(2.0, 9.0, -1.0),
                Eigen::Vector3d(-9.0, 0.0, 10.0)});
  EXPECT_EQ(wedge.corner(), Corner::outside);
  const Moments moments = wedge.volume(Corner::outside);
  EXPECT_NEAR(moments[0], 1.0 / 2.0, rounding);             // 1
  EXPECT_NEAR(moments[1], 1.0 / 6.0, rounding);             // x
  EXPECT_NEAR(moments[1 + 3], 1.0 / 12.0, rounding);        // x y
  EXPECT_NEAR(moments[2], 1.0 / 12.0, rounding);            // x²
  EXPECT_NEAR(moments[1 + 9], 1.0 / 24.0, rounding);        // x z
  EXPECT_NEAR(moments[2 + 6 + 18], 1.0 / 540.0, rounding);  // x² y² z²
  EXPECT_NEAR(wedge.surface()[0], std::sqrt(2.0), rounding);
  // The half below x + y + z = 3/2: the three axes alike, and with its mirror image the cube.
  CutCell half, mirrored;
  const Eigen::Vector3d a(3.5, -1.0, -1.0), b(-1.0, 3.5, -1.0), c(-1.0, -1.0, 3.5);
  half.add(0, {a, b, c});
  mirrored.add(0, {a, c, b});
  const Moments below = half.volume(half.corner().value());
  const Moments above = mirrored.volume(mirrored.corner().value());
  EXPECT_NEAR(below[0], 0.5, rounding);
  EXPECT_NEAR(below[1], below[3], rounding);
  EXPECT_NEAR(below[1], below[9], rounding);
  for (std::size_t k = 0; k < 27; ++k) {
    const double whole =
        1.0 / ((static_cast<double>(k % 3) + 1.0) * (static_cast<double>(k / 3 % 3) + 1.0) *
               (static_cast<double>(k / 9) + 1.0));
    EXPECT_NEAR(below[k] + above[k], whole, rounding) << k;
  }
}

TEST(EmbeddedGeometry, NeighboursDifferByOneLevelAtMost) {
  Octree tree(icosphere(1.0, 2, {0.0, 0.0, 0.0}));
  tree.refine_surface(6);
  for (const int leaf : tree.leaves()) {
    const Cube& cube = tree.cube(leaf);
    for (int direction = 0; direction < 27; ++direction) {
      const int other = tree.containing(
          cube.level, {static_cast<std::int64_t>(cube.at[0]) + direction % 3 - 1,
                       static_cast<std::int64_t>(cube.at[1]) + direction / 3 % 3 - 1,
                       static_cast<std::int64_t>(cube.at[2]) + direction / 9 - 1});
      if (other >= 0) {
        ASSERT_GE(tree.cube(other).level, cube.level - 1);
      }
    }
  }
}

TEST(EmbeddedGeometry, ALeafIsFoundFromAnyNode) {
  Octree tree(icosphere(1.0, 2, {0.0, 0.0, 0.0}));
  tree.refine_surface(4);
  const std::vector<int> leaves = tree.leaves();
  for (std::size_t k = 0; k < leaves.size(); ++k) {
    const Cube& cube = tree.cube(leaves[k]);
    const Eigen::Vector3d middle(cube.at[0] + 0.5, cube.at[1] + 0.5, cube.at[2] + 0.5);
    for (const int near : {0, leaves[k], leaves[leaves.size() - 1 - k]}) {
      ASSERT_EQ(tree.leaf_at(std::ldexp(1.0, -cube.level) * middle, near), leaves[k]);
    }
  }
}

TEST(EmbeddedGeometry, BodiesKeepTheirVoids) {
  Eigen::Affine3d aside = Eigen::Affine3d::Identity();
  aside.translate(Eigen::Vector3d(10.01, 0.0, 0.0));
  const TriangleMesh mesh = joined(box_with_void(), transformed(box({5.0, 5.0, 5.0}, 1), aside));
  const auto found = bodies(mesh, *make_caster(mesh));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(enclosed_volume(found[0].mesh), 1000.0 - 64.0, 1e-9);
  EXPECT_NEAR(enclosed_volume(found[1].mesh), 125.0, 1e-9);
}

TEST(EmbeddedGeometry, FoldsAreCubesWithTwoSidesOfTheSurface) {
  EXPECT_GT(
      folds(cut_at(box({10.0, 10.0, 0.003}, 1), 4), surface_of(box({10.0, 10.0, 0.003}, 1))).size(),
      100U);
  const TriangleMesh ball = icosphere(5.0, 3, {0.1, 0.2, 0.3});
  EXPECT_TRUE(folds(cut_at(ball, 4), surface_of(ball)).empty());
}

}  // namespace
}  // namespace kappamu::forward::embedded
