// Blocks wrapped round objects: what shell maps and mean-value interpolation promise. That scenes
// take the placement is tested in scene_test.cpp.
#include "render/scene/shell.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/mesh/shapes.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;

constexpr double radius = 6.0, voxel = 0.4;
constexpr GridShape block_shape{8, 6, 4, voxel};

io::VolumeSet block_of(const std::function<double(int x, int y, int z)>& mu) {
  io::VolumeSet set;
  set.channels = {"grey"};
  set.media.push_back({Volume<double>(block_shape, 0.3), Volume<double>(block_shape, 0.0)});
  for (int z = 0; z < block_shape.nz; ++z) {
    for (int y = 0; y < block_shape.ny; ++y) {
      for (int x = 0; x < block_shape.nx; ++x) set.media[0].mu(x, y, z) = mu(x, y, z);
    }
  }
  return set;
}

/// Where voxels stretched into a mesh's box lie.
class PlaceOf {
 public:
  PlaceOf(const TriangleMesh& mesh, const GridShape& shape)
      : corner_(bounding_box(mesh).min()),
        step_(bounding_box(mesh).sizes().array() / Eigen::Array3d(shape.nx, shape.ny, shape.nz)) {}
  Vector3d operator()(const Eigen::Vector3i& at) const {
    return corner_.array() + step_ * (at.cast<double>().array() + 0.5);
  }

 private:
  Vector3d corner_;
  Eigen::Array3d step_;
};

/// Calls check(depth below the surface [mm], μ) for every voxel in the ball.
template <class Check>
void for_voxels_of_ball(const io::VolumeSet& block, const Check& check) {
  const TriangleMesh ball = sphere_mesh(radius, 24);
  const io::VolumeSet around = wrapped(block, ball, Vector3d::Zero());
  const GridShape& shape = around.shape();
  const PlaceOf place(ball, shape);
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const Vector3d at = place({x, y, z});
        if (at.norm() < radius) check(radius - at.norm(), around.media[0].mu(x, y, z));
      }
    }
  }
}

TEST(Shell, LayersLieAtTheirDepthAndTheLastGoesOn) {
  // The face z+ is outside.
  const io::VolumeSet block = block_of([](int, int, int z) { return 0.01 * (block_shape.nz - z); });
  // Facets of the mesh, and of the polygrid, lie below the ball's surface [mm].
  constexpr double surfaces = 0.06;
  int in_shell = 0, deeper = 0;
  for_voxels_of_ball(block, [&](double depth, double mu) {
    if (depth > block_shape.nz * voxel + surfaces) {
      ++deeper;
      EXPECT_NEAR(mu, 0.01 * block_shape.nz, 1e-12) << depth;
      return;
    }
    const double layer = depth / voxel, off = layer - std::floor(layer);
    if (off * voxel < surfaces || (1.0 - off) * voxel < surfaces) return;
    if (depth > block_shape.nz * voxel) return;
    ++in_shell;
    EXPECT_NEAR(mu, 0.01 * (std::floor(layer) + 1.0), 1e-12) << depth;
  });
  EXPECT_GT(in_shell, 1000);
  EXPECT_GT(deeper, 1000);
}

TEST(Shell, KeepsTheBlocksSharesAndRange) {
  // Columns of the block, a quarter of them dark.
  const io::VolumeSet block = block_of([](int x, int, int) { return x % 4 == 0 ? 0.05 : 0.01; });
  double dark = 0.0, all = 0.0;
  for_voxels_of_ball(block, [&](double depth, double mu) {
    EXPECT_GE(mu, 0.01 - 1e-12);
    EXPECT_LE(mu, 0.05 + 1e-12);
    if (depth > 0.5) return;
    ++all;
    if (mu > 0.03) ++dark;
  });
  constexpr double whole_columns = 0.05;  // the polycube's faces end within one
  EXPECT_NEAR(dark / all, 0.25, whole_columns);
}

/// A pattern that changes slowly in the block does so all round the object, across the edges of its
/// polycube too: most of a step is the pattern's own; two views that end at an edge leave twice it.
TEST(Shell, GoesOnAllRoundTheObject) {
  constexpr GridShape large{20, 15, 4, voxel};
  constexpr double mean = 0.05, swing = 0.02;
  io::VolumeSet block;
  block.channels = {"grey"};
  block.media.push_back({Volume<double>(large, 0.3), Volume<double>(large, 0.0)});
  for (std::size_t i = 0; i < large.cells(); ++i) {
    const double x = M_PI * static_cast<double>(i % 20) / 20.0,
                 y = M_PI * static_cast<double>(i / 20 % 15) / 15.0;
    block.media[0].mu[i] = mean + swing * (std::cos(x) + std::cos(y));
  }
  constexpr double outer = 2.0 * radius, depth = large.nz * voxel;
  const TriangleMesh ball = sphere_mesh(outer, 24);
  const io::VolumeSet around = wrapped(block, ball, Vector3d::Zero());
  const GridShape& shape = around.shape();
  const PlaceOf place(ball, shape);
  const auto in_shell = [&](const Eigen::Vector3i& at) {
    return place(at).norm() < outer && place(at).norm() > outer - 0.9 * depth;
  };
  const Volume<double>& mu = around.media[0].mu;
  double step = 0.0, least = mean, most = mean;
  for (int z = 0; z + 1 < shape.nz; ++z) {
    for (int y = 0; y + 1 < shape.ny; ++y) {
      for (int x = 0; x + 1 < shape.nx; ++x) {
        const Eigen::Vector3i here(x, y, z);
        if (!in_shell(here)) continue;
        least = std::min(least, mu(x, y, z));
        most = std::max(most, mu(x, y, z));
        for (int axis = 0; axis < 3; ++axis) {
          const Eigen::Vector3i next = here + Eigen::Vector3i::Unit(axis);
          if (!in_shell(next)) continue;
          step = std::max(step, std::abs(mu(next[0], next[1], next[2]) - mu(x, y, z)));
        }
      }
    }
  }
  EXPECT_GT(most - least, 3.0 * swing);
  EXPECT_LT(step, 0.6 * swing);
}

/// Interpolated values are means of the shell's: the ball's middle has about that of all.
TEST(Shell, InteriorIsAMeanOfTheLastLayer) {
  const io::VolumeSet block = block_of([](int x, int, int) { return x % 4 == 0 ? 0.05 : 0.01; });
  double sum = 0.0;
  int count = 0;
  for_voxels_of_ball(block, [&](double depth, double mu) {
    if (depth < 0.8 * radius) return;
    sum += mu;
    ++count;
  });
  ASSERT_GT(count, 20);
  EXPECT_NEAR(sum / count, 0.02, 0.002);
}

}  // namespace
}  // namespace kappamu::render
