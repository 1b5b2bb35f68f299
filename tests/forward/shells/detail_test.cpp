// Level of detail: no shell pops, and fewer shells show what all of them do from far away.
#include "forward/shells/detail.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace kappamu::forward::shells {

namespace {

using Eigen::Vector3d;

HairTexture coat() {
  HairOptions options;
  options.width = 32;
  options.layers = 16;
  options.coats = {{6000, 0.05, 0.12, 0.1, 0.5, 0.3}, {400, 0.2, 0.45, 0.5, 1.0, 0.3}};
  return make_hair_texture(options);
}

TexelRadiance by_height(const HairTexture& texture) {
  return [&](std::size_t texel) -> Eigen::Array3d {
    return Eigen::Array3d::Constant(static_cast<double>(texel / (32 * 32) + 1) / texture.layers);
  };
}

/// Mean over the tile of what is seen along a direction, 35 degrees off the normal.
double mean_seen(const LitLevels& lit, const ShellDetail& detail) {
  const Vector3d down = Vector3d(0.5, 0.3, -0.85).normalized();
  double sum = 0.0;
  for (int i = 0; i < 1024; ++i) {
    const Vector3d from(i % 32 + 0.37, i / 32 + 0.61, lit.height);
    sum += seen_by_detail(lit, detail, from, down).radiance[0];
  }
  return sum / 1024;
}

TEST(ShellDetail, OfAllShellsIsSmoothLookup) {
  const HairTexture texture = coat();
  const auto radiance = by_height(texture);
  const LitLevels lit = lit_levels(texture, texture.extinction, radiance);
  const Vector3d down = Vector3d(0.2, -0.4, -0.8).normalized();
  for (int i = 0; i < 40; ++i) {
    const Vector3d from(0.9 * i, 17.3 - 0.7 * i, 20.0);
    const SeenHair all = seen_by_shells(texture, texture.extinction, from, down, radiance);
    const SeenHair seen = seen_by_detail(lit, {16, 0.0}, from, down);
    EXPECT_NEAR(seen.radiance[0], all.radiance[0], 1e-9);
    EXPECT_NEAR(seen.transmittance, all.transmittance, 1e-9);
  }
}

TEST(ShellDetail, ChangesWithoutAStep) {
  const LitLevels lit = lit_levels(coat(), 6.0, by_height(coat()));
  const Vector3d down = Vector3d(0.2, -0.4, -0.8).normalized();
  for (int i = 0; i < 40; ++i) {
    const Vector3d from(0.9 * i, 17.3 - 0.7 * i, 20.0);
    // Where pairs have merged, half of the shells is the same.
    EXPECT_NEAR(seen_by_detail(lit, {16, 1.0}, from, down).radiance[0],
                seen_by_detail(lit, {8, 0.0}, from, down).radiance[0], 1e-9);
  }
  double before = 16.0;
  for (double height = 20.0; height > 2.0; height *= 0.99) {
    const ShellDetail detail = ShellDetail::of(16, height);
    double weights = 0.0;
    for (int i = 0; i < detail.count; ++i) weights += detail.weight(i);
    EXPECT_NEAR(weights, detail.count, 1e-12);
    const double stands_for = 16.0 * std::exp2(-detail.level(16));
    EXPECT_LE(stands_for, before + 1e-9);
    EXPECT_GT(stands_for, 0.98 * before);
    before = stands_for;
  }
  EXPECT_NEAR(before, 4.0, 1e-9);
}

TEST(ShellDetail, KeepsTheMeanLight) {
  // Halved texels hold the same hair, spread: shells of half and a quarter of the number err by
  // that alone.
  const HairTexture texture = coat();
  const LitLevels lit = lit_levels(texture, texture.extinction, by_height(texture));
  const double all = mean_seen(lit, {16, 0.0});
  EXPECT_NEAR(mean_seen(lit, {16, 0.5}), all, 0.06 * all);
  EXPECT_NEAR(mean_seen(lit, {8, 0.0}), all, 0.10 * all);
  EXPECT_NEAR(mean_seen(lit, {4, 0.0}), all, 0.20 * all);
}

}  // namespace

}  // namespace kappamu::forward::shells
