// What an eye sees of a flat coat: shells against the integral along the ray, and closed forms.
#include "forward/shells/lit_hair.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "forward/shells/frame.h"

namespace kappamu::forward::shells {

namespace {

using Eigen::Array3d;
using Eigen::Vector3d;

HairTexture even_texture(float density) {
  HairTexture texture;
  texture.width = 4;
  texture.layers = 30;
  texture.layer_height = 0.5;
  texture.density.assign(480, density);
  texture.depth.assign(480, 0.5F);
  texture.shade.assign(480, 0.5F);
  texture.tangent.assign(480, Eigen::Vector3f(0, 0, 1));
  return texture;
}

TEST(SeenHair, OfAnEvenCoatIsBeersLaw) {
  const HairTexture texture = even_texture(0.3F);
  const Vector3d down = Vector3d(0.4, 0.1, -0.8).normalized(), from(1.2, 3.4, 30.0);
  const auto one = [](std::size_t) { return Array3d(Array3d::Ones()); };
  const double r = 0.1, left = std::exp(-r * texture.density[0] * 15.0 / -down.z());
  for (const SeenHair& seen :
       {seen_by_shells(texture, r, from, down, one), seen_by_ray(texture, r, from, down, one)}) {
    EXPECT_NEAR(seen.transmittance, left, 1e-12);
    EXPECT_NEAR(seen.radiance[1], 1.0 - left, 1e-12);
  }
}

TEST(SeenHair, StartsAtTheTopFromAnyHeight) {
  // Rounding of the way to the top must not lose a ray.
  const HairTexture texture = even_texture(0.3F);
  for (std::uint64_t i = 0; i < 200; ++i) {
    const Vector3d down = Vector3d(uniform(key_of({i, 0})), 0.3, -0.7).normalized();
    const SeenHair seen =
        seen_by_ray(texture, 1.0, {0.1, 0.2, 20.0 + 9.0 * uniform(key_of({i, 1}))}, down,
                    [](std::size_t) { return Array3d(Array3d::Ones()); });
    EXPECT_LT(seen.transmittance, 0.02);
  }
}

TEST(SeenHair, ByShellsIsTheIntegralAlongTheRayOnTheAverage) {
  // Over a whole tile. Shells err with the layer's height; of the tile's mean 3 % bound it here.
  HairOptions options;
  options.width = 16;
  options.layers = 24;
  options.layer_height = 0.5;
  options.coats = {{600, 0.1, 0.2, 0.3, 1.0, 0.3}};
  const HairTexture texture = make_hair_texture(options);
  const auto light = [&](std::size_t i) { return Array3d(Array3d::Constant(texture.depth[i])); };
  double shells = 0.0, ray = 0.0;
  const Vector3d down = Vector3d(0.3, 0.2, -0.9).normalized();
  for (std::uint32_t i = 0; i < 4000; ++i) {
    const auto [u, v] = sobol_point(i, 4);
    const Vector3d from(16 * u, 16 * v, 13.0);
    shells += seen_by_shells(texture, texture.extinction, from, down, light).radiance[0];
    ray += seen_by_ray(texture, texture.extinction, from, down, light).radiance[0];
  }
  EXPECT_NEAR(shells, ray, 0.03 * ray);
}

TEST(LitHair, OfALampIsItsTransmittanceTimesReflectance) {
  // In even density T depends on the height alone and is smooth up to the horizon, where it is
  // dark already: five bands hold it, but for a few per cent of one.
  const HairTexture texture = even_texture(0.2F);
  Progress progress;
  const Transfer transfer = make_transfer(texture, {6, 2048, 2.0}, progress);
  const HairColour colour;
  const HairReflectance even(HairModel::even);
  const LitHair hair{texture, transfer, colour, even};
  const std::vector<Lamp> lamps{{Vector3d(0.3, 0.2, 0.9).normalized(), Array3d(1.0, 2.0, 3.0)}};
  const PlaceLight light = light_of(6, lamps);
  for (const int layer : {18, 24, 27}) {
    const std::size_t texel = texture.texel(1, 2, layer);
    const Array3d truth = hair.radiance_by_rays(texel, lamps, Vector3d::UnitZ());
    const Array3d seen = hair.radiance(texel, light, Vector3d::UnitZ());
    const Array3d unit = lamps[0].irradiance * colour.at(0.5, 0.5) * (0.25 / std::numbers::pi);
    EXPECT_LT(((seen - truth) / unit).abs().maxCoeff(), 0.12) << layer;
    EXPECT_NEAR(truth[0] / unit[0],
                std::exp(-0.4 * (15.0 - (layer + 0.5) * 0.5) / lamps[0].direction.z()), 1e-6);
  }
}

TEST(FrameDrawer, DrawsWhatShellsShow) {
  HairOptions options;
  options.width = 13;
  options.layers = 9;
  options.coats = {{300, 0.1, 0.2, 0.3, 1.0, 0.3}};
  const HairTexture texture = make_hair_texture(options);
  Progress progress;
  const Transfer transfer = make_transfer(texture, {3, 64, 0.0}, progress);
  const HairColour colour;
  const HairReflectance kajiya(HairModel::kajiya_kay);
  const PlaceLight light = light_of(3, {{Vector3d(0.3, 0.2, 0.9).normalized(), Array3d::Ones()}});
  const Vector3d eye(3.0, -7.0, 25.0), target(5.0, 5.0, 0.0), towards = (eye - target).normalized();
  const FrameDrawer drawer(texture, transfer, colour, 31, 17);
  const Image<float> frame = drawer.drawn(drawer.lit(light, towards, kajiya), eye, target, 40.0);
  const LitHair hair{texture, transfer, colour, kajiya};
  const Vector3d forward = -towards, right = forward.cross(Vector3d::UnitZ()).normalized();
  const Vector3d up = right.cross(forward);
  const double half = std::tan(20.0 * std::numbers::pi / 180.0);
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 31; ++x) {
      const Vector3d d = (forward + (2.0 * (x + 0.5) / 31 - 1.0) * half * 31 / 17 * right +
                          (1.0 - 2.0 * (y + 0.5) / 17) * half * up)
                             .normalized();
      const SeenHair seen = seen_by_shells(texture, transfer.r, eye, d, [&](std::size_t texel) {
        return hair.radiance(texel, light, towards);
      });
      // A frame's pixel is left when a hundredth of what lies behind would be seen.
      EXPECT_NEAR(frame(x, y, 0), seen.radiance[0], 2e-3 * (0.01 + seen.radiance[0]) + 1e-3);
    }
  }
}

}  // namespace

}  // namespace kappamu::forward::shells
