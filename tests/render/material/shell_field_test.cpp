// Blocks wrapped round objects: layers lie at their depths, statistics are the block's, nothing is
// repeated or mirrored. That scenes take the placement is tested in scene_test.cpp.
#include "render/material/shell_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <numeric>

#include "core/error.h"
#include "core/mesh/shapes.h"
#include "core/process_memory.h"
#include "core/processor_time.h"
#include "core/random.h"
#include "render/material/baked_field.h"
#include "render/material/surface_places.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;

constexpr double voxel = 0.4;
constexpr GridShape block_shape{48, 44, 6, voxel};

io::VolumeSet block_of(const GridShape& shape,
                       const std::function<double(int x, int y, int z)>& mu) {
  io::VolumeSet set;
  set.channels = {"grey"};
  set.media.push_back({Volume<double>(shape, 0.3), Volume<double>(shape, 0.0)});
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) set.media[0].mu(x, y, z) = mu(x, y, z);
    }
  }
  return set;
}

/// Noise whose correlation falls to nothing within a few voxels.
std::vector<double> smooth_noise(const GridShape& shape, std::uint64_t seed) {
  constexpr int reach = 2;
  std::vector<double> result(shape.cells());
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        double sum = 0.0;
        for (int dz = -1; dz <= 1; ++dz) {
          for (int dy = -reach; dy <= reach; ++dy) {
            for (int dx = -reach; dx <= reach; ++dx) {
              const auto part = [](int a) { return static_cast<std::uint64_t>(a + 1000); };
              const double white =
                  uniform(key_of({seed, part(x + dx), part(y + dy), part(z + dz)}));
              sum += (white - 0.5) * std::exp(-0.3 * (dx * dx + dy * dy));
            }
          }
        }
        result[shape.index(x, y, z)] = sum;
      }
    }
  }
  return result;
}

/// R, G, B with skewed histograms, κ and μ correlated with each other and over the channels.
io::VolumeSet random_block(std::uint64_t seed) {
  const std::vector<double> one = smooth_noise(block_shape, seed),
                            two = smooth_noise(block_shape, seed + 1);
  io::VolumeSet set;
  set.channels = {"R", "G", "B"};
  for (int c = 0; c < 3; ++c) {
    Medium medium{Volume<double>(block_shape), Volume<double>(block_shape)};
    for (std::size_t i = 0; i < block_shape.cells(); ++i) {
      const double mixed = one[i] + 0.3 * c * two[i];
      medium.kappa[i] = 0.2 + 0.1 / (1.0 + std::exp(-4.0 * (mixed - two[i])));
      medium.mu[i] = 0.02 * std::exp(1.5 * mixed);
    }
    set.media.push_back(std::move(medium));
  }
  return set;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double ma = mean(a), mb = mean(b);
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - ma) * (b[i] - mb);
    aa += (a[i] - ma) * (a[i] - ma);
    bb += (b[i] - mb) * (b[i] - mb);
  }
  return ab / std::sqrt(aa * bb);
}

/// μ of red, κ of red, μ of blue along a flat layer, [coefficient][y][x].
struct Layer {
  int nx = 0, ny = 0;
  std::array<std::vector<double>, 3> values;
  const double& at(std::size_t k, int x, int y) const {
    return values[k][static_cast<std::size_t>(y * nx + x)];
  }
  /// Of one coefficient at a distance of `dx`, `dy` cells.
  double two_point(std::size_t k, int dx, int dy) const {
    std::vector<double> a, b;
    for (int y = 0; y + dy < ny; ++y) {
      for (int x = 0; x + dx < nx; ++x) {
        a.push_back(at(k, x, y));
        b.push_back(at(k, x + dx, y + dy));
      }
    }
    return correlation(a, b);
  }
};

Layer layer_of_block(const io::VolumeSet& block, int z) {
  const GridShape& s = block.shape();
  Layer layer{s.nx, s.ny, {}};
  for (int y = 0; y < s.ny; ++y) {
    for (int x = 0; x < s.nx; ++x) {
      layer.values[0].push_back(block.media[0].mu(x, y, z));
      layer.values[1].push_back(block.media[0].kappa(x, y, z));
      layer.values[2].push_back(block.media[2].mu(x, y, z));
    }
  }
  return layer;
}

/// At a layer's middle below the top of a wide slab.
Layer layer_of_shell(const ShellField& field, const TriangleMesh& slab, int below, int cells) {
  const SurfacePlaces places(slab);
  const Eigen::AlignedBox3d box = bounding_box(slab);
  Layer layer{cells, cells, {}};
  double outside = 0.0;
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      const Vector3d point(voxel * (x - 0.5 * cells), voxel * (y - 0.5 * cells),
                           box.max().z() - (below + 0.5) * voxel);
      const ColourCoefficients here = field.at(places.at(point, 0, outside));
      layer.values[0].push_back(here[0].mu);
      layer.values[1].push_back(here[0].kappa);
      layer.values[2].push_back(here[2].mu);
    }
  }
  return layer;
}

constexpr int wide = 150;  // cells of a synthesised layer, three times the block's
TriangleMesh slab() {
  return box_mesh({1.2 * wide * voxel, 1.2 * wide * voxel, 8.0}, 40);
}

TEST(ShellField, LayersLieAtTheirDepthAndTheLastGoesOn) {
  constexpr GridShape shape{24, 20, 4, voxel};
  const io::VolumeSet block =
      block_of(shape, [](int, int, int z) { return 0.01 * (shape.nz - z); });
  const TriangleMesh ball = sphere_mesh(6.0, 24);
  Shell shell;
  shell.core = Shell::Core::mean_values;
  const ShellField field(block, shell, ball);
  const SurfacePlaces places(ball);
  double outside = 0.0;
  for (double depth = 0.05; depth < 5.5; depth += 0.1) {
    const Place place =
        places.at((6.0 - depth) * Vector3d(0.3, -0.5, 0.81).normalized(), 0, outside);
    const int layer = std::min(static_cast<int>(place.depth / voxel), shape.nz - 1);
    EXPECT_NEAR(field.at(place)[1].mu, 0.01 * (layer + 1), 1e-8) << depth;
  }
}

/// A void's wall is a surface too, with the block's face on it.
TEST(ShellField, LinesVoidsToo) {
  constexpr GridShape shape{24, 20, 3, 0.2};
  const io::VolumeSet block =
      block_of(shape, [](int, int, int z) { return 0.01 * (shape.nz - z); });
  const TriangleMesh hollow = joined(sphere_mesh(6.0, 24), turned_inside_out(sphere_mesh(3.0, 24)));
  const ShellField field(block, {}, hollow);
  const SurfacePlaces places(hollow);
  double outside = 0.0;
  const Place wall = places.at({0.0, 3.1, 0.0}, 0, outside);
  EXPECT_LT(outside, 0.0);
  EXPECT_NEAR(field.at(wall)[0].mu, 0.01, 1e-8);
}

/// Shares of the block's deciles, correlations over κ, μ and channels, and of places one to four
/// voxels apart are the block's within three standard errors of as many independent places as the
/// block's layer has: its area over that of a correlated spot.
TEST(ShellField, HasTheBlocksStatistics) {
  constexpr double correlated_cells = 20.0;
  const double error = 3.0 / std::sqrt(block_shape.nx * block_shape.ny / correlated_cells);
  const TriangleMesh object = slab();
  for (const std::uint64_t seed : {11U, 12U}) {
    const io::VolumeSet block = random_block(seed);
    const ShellField field(block, {}, object);
    const Layer given = layer_of_block(block, block_shape.nz - 2),
                made = layer_of_shell(field, object, 1, wide);
    for (std::size_t k = 0; k < 3; ++k) {
      std::vector<double> sorted = given.values[k];
      std::sort(sorted.begin(), sorted.end());
      for (int decile = 1; decile < 10; ++decile) {
        const double value = sorted[sorted.size() * static_cast<std::size_t>(decile) / 10];
        const auto below = std::count_if(made.values[k].begin(), made.values[k].end(),
                                         [&](double v) { return v < value; });
        const double share = static_cast<double>(below) / (wide * wide);
        EXPECT_NEAR(share, 0.1 * decile, 0.5 * error) << seed << " " << k << " " << decile;
      }
      for (const int apart : {1, 2, 3, 4}) {
        EXPECT_NEAR(made.two_point(k, apart, 0), given.two_point(k, apart, 0), error) << apart;
        EXPECT_NEAR(made.two_point(k, 0, apart), given.two_point(k, 0, apart), error) << apart;
      }
    }
    EXPECT_NEAR(correlation(made.values[0], made.values[1]),
                correlation(given.values[0], given.values[1]), error);
    EXPECT_NEAR(correlation(made.values[0], made.values[2]),
                correlation(given.values[0], given.values[2]), error);
  }
}

/// A period or a mirror line would correlate places fully; noise correlates them by the reciprocal
/// root of the independent places compared.
TEST(ShellField, NeitherRepeatsNorMirrors) {
  const TriangleMesh object = slab();
  const io::VolumeSet block = random_block(21);
  const Layer made = layer_of_shell(ShellField(block, {}, object), object, 0, wide);
  constexpr double correlated_cells = 20.0, errors = 6.0;
  for (int apart = 10; apart < wide / 2; ++apart) {
    const double bound = errors / std::sqrt((wide - apart) * wide / correlated_cells);
    EXPECT_LT(std::abs(made.two_point(0, apart, 0)), bound) << apart;
    EXPECT_LT(std::abs(made.two_point(0, 0, apart)), bound) << apart;
  }
  constexpr int nearest = 5, farthest = 25;
  const double bound = errors / std::sqrt((farthest - nearest) * wide / correlated_cells);
  for (int line = farthest; line + farthest < wide; ++line) {
    std::vector<double> left, right, above, below;
    for (int t = nearest; t < farthest; ++t) {
      for (int along = 0; along < wide; ++along) {
        left.push_back(made.at(0, line - t, along));
        right.push_back(made.at(0, line + t, along));
        above.push_back(made.at(0, along, line - t));
        below.push_back(made.at(0, along, line + t));
      }
    }
    EXPECT_LT(std::abs(correlation(left, right)), bound) << line;
    EXPECT_LT(std::abs(correlation(above, below)), bound) << line;
  }
}

TEST(ShellField, TakesValuesOfTheBlockAlone) {
  const io::VolumeSet block = random_block(31);
  std::vector<float> known;
  for (const double mu : block.media[1].mu.values()) known.push_back(static_cast<float>(mu));
  std::sort(known.begin(), known.end());
  const TriangleMesh ring = torus_mesh(10.0, 4.0, 40);
  std::vector<std::string> warnings;
  const Baked voxels = baked(ShellField(block, {}, ring), ring, warnings);
  EXPECT_TRUE(warnings.empty());
  for (const double mu : voxels.set.media[1].mu.values()) {
    ASSERT_TRUE(std::binary_search(known.begin(), known.end(), static_cast<float>(mu))) << mu;
  }
}

/// The core has the histogram of the whole block; by mean values it is its last layer's mean.
TEST(ShellField, CoreIsSynthesisedOrInterpolated) {
  const io::VolumeSet block = block_of(
      block_shape, [](int x, int y, int) { return (x / 3 + y / 3) % 4 == 0 ? 0.05 : 0.01; });
  const TriangleMesh ball = sphere_mesh(14.0, 24);
  const SurfacePlaces places(ball);
  for (const Shell::Core core : {Shell::Core::synthesised, Shell::Core::mean_values}) {
    Shell shell;
    shell.core = core;
    const ShellField field(block, shell, ball);
    std::vector<double> values;
    double outside = 0.0;
    for (std::uint64_t i = 0; i < 4000; ++i) {
      const Vector3d point =
          10.0 * Vector3d(uniform(key_of({i, 1})) - 0.5, uniform(key_of({i, 2})) - 0.5,
                          uniform(key_of({i, 3})) - 0.5);
      values.push_back(field.at(places.at(point, 0, outside))[0].mu);
    }
    const auto mixed = std::count_if(values.begin(), values.end(),
                                     [](double mu) { return mu > 0.0101 && mu < 0.0499; });
    EXPECT_NEAR(mean(values), 0.02, 0.003);
    EXPECT_EQ(mixed == 0, core == Shell::Core::synthesised);
  }
}

/// A square whose texture coordinates lie on the face once has the face as it is.
TEST(ShellField, FollowsTextureCoordinates) {
  const io::VolumeSet block = random_block(41);
  TriangleMesh box = box_mesh({10.0, 8.0, 4.0}, 8);
  Shell shell;
  shell.texture_size_mm = {10.0, 8.0};
  EXPECT_THROW(ShellField(block, shell, box), InputError);
  for (const auto& t : box.triangles) {
    CornerTexture& corners = box.texture.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d& v = box.vertices[static_cast<std::size_t>(t[k])];
      corners[k] = {static_cast<float>(v.x() / 10.0 + 0.5), static_cast<float>(v.y() / 8.0 + 0.5)};
    }
  }
  const ShellField once(block, shell, box);
  const SurfacePlaces places(box);
  double outside = 0.0;
  for (int y = 5; y < 15; ++y) {
    for (int x = 5; x < 20; ++x) {
      const Vector3d point(voxel * (x + 0.5) - 5.0, voxel * (y + 0.5) - 4.0, 2.0 - 0.5 * voxel);
      EXPECT_EQ(static_cast<float>(once.at(places.at(point, 0, outside))[2].mu),
                static_cast<float>(block.media[2].mu(x, y, block_shape.nz - 1)));
    }
  }
  // Larger, the face is continued: without jumps where the lattice's triangles meet.
  shell.texture_size_mm = {300.0, 240.0};
  const ShellField continued(block, shell, box);
  const Place edge = places.at({0.1, 0.2, 1.9}, 0, outside);
  EXPECT_GT(continued.at(edge)[0].mu, 0.0);
}

/// Not among the quick tests: a block of a million voxels on 100,000 triangles, 30 s on two cores.
TEST(ShellField, DISABLED_WrapsAMillionVoxelsInHalfAMinute) {
  constexpr GridShape large{200, 200, 25, 0.1};
  io::VolumeSet block = block_of(large, [](int x, int y, int z) {
    return 0.02 + 0.01 * std::sin(0.3 * x + 0.002 * y * y) + 0.0001 * z;
  });
  block.channels = {"R", "G", "B"};
  block.media.resize(3, block.media[0]);
  const TriangleMesh ring = torus_mesh(25.0, 9.0, 150);
  std::vector<std::string> warnings;
  const double start = processor_seconds();
  const ShellField field(block, {}, ring);
  const double laid = processor_seconds();
  const Baked voxels = baked(field, ring, warnings);
  std::printf(
      "%zu triangles, %zu voxels: pieces %.1f s, voxels %.1f s of processor, scores %s, "
      "voxels %s\n",
      ring.triangles.size(), voxels.set.shape().cells(), laid - start, processor_seconds() - laid,
      gigabytes(NormalScores::bytes(block)).c_str(),
      gigabytes(bytes_per_baked_voxel * most_baked_voxels).c_str());
  EXPECT_GT(ring.triangles.size(), 100'000U);
  EXPECT_LT(processor_seconds() - start, 60.0);
}

}  // namespace
}  // namespace kappamu::render
