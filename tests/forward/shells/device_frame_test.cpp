// The frame by OpenCL against the plain reference, pixel by pixel. How fast it is, `kappamu-studies
// fur --section speed` measures.
#include "forward/shells/device_frame.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/progress.h"

namespace kappamu::forward::shells {

namespace {

using Eigen::Vector3d;

/// A group of pixels has the opacities of one slant. Slants are up to 1.04 apart, of which half is
/// the error of an optical depth; opacity errs most at a depth of one, by 1/e of that. Sixteen bits
/// lose 1e-3 of `white` over all shells, and what lies behind a hundredth is left out.
constexpr double of_light = 0.02 / std::numbers::e + 0.01, of_white = 1e-3;

void expect_reference(int width, int layers, HairModel model) {
  HairOptions options;
  options.width = width;
  options.layers = layers;
  options.coats = {{width * width, 0.1, 0.3, 0.3, 1.0, 0.3}};
  const HairTexture texture = make_hair_texture(options);
  Progress progress;
  const Transfer transfer = make_transfer(texture, {3, 64, 0.0}, progress);
  const HairColour colour;
  const HairReflectance reflectance(model);
  const PlaceLight light = light_of(3, {{Vector3d(0.3, 0.2, 0.9).normalized(), {3.0, 2.0, 1.0}}});
  const double tile = width;
  const Vector3d eye(0.3 * tile, -0.5 * tile, 2.0 * tile), target(0.5 * tile, 0.5 * tile, 0.0);
  const Vector3d towards = (eye - target).normalized();
  constexpr int columns = 37, rows = 19;  // no multiple of a work item's eight
  device::Context& context = device::Context::chosen("auto");
  DeviceFrame frame(context, texture, transfer, colour, columns, rows);
  frame.light(light, towards, reflectance);
  frame.draw(eye, target, 8.0, true);
  const Image<float> picture = frame.picture();
  const LitHair hair{texture, transfer, colour, reflectance};
  const Vector3d forward = -towards, right = forward.cross(Vector3d::UnitZ()).normalized();
  const Vector3d up = right.cross(forward);
  const double half = std::tan(4.0 * std::numbers::pi / 180.0);
  double brightest = 0.0;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const Vector3d d =
          (forward + (2.0 * (x + 0.5) / columns - 1.0) * half * columns / rows * right +
           (1.0 - 2.0 * (y + 0.5) / rows) * half * up)
              .normalized();
      const SeenHair seen = seen_by_shells(
          texture, transfer.r, eye, d,
          [&](std::size_t texel) { return hair.radiance(texel, light, towards); }, Lookup::opacity);
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(picture(x, y, c), seen.radiance[c],
                    of_light * seen.radiance[c] + of_white * frame.white())
            << "pixel " << x << ", " << y << ", width " << width;
      }
      brightest = std::max(brightest, seen.radiance[0]);
    }
  }
  EXPECT_GT(brightest, 0.05 * frame.white());
}

TEST(DeviceFrame, IsEquivalentToReference) {
  expect_reference(16, 8, HairModel::kajiya_kay);
  expect_reference(13, 9, HairModel::kajiya_kay);  // places are no power of two
  expect_reference(16, 8, HairModel::marschner);   // lit by the host
}

TEST(DeviceFrame, InterpolatesWhereTexelsAreWide) {
  HairOptions options;
  options.width = 16;
  options.layers = 8;
  options.coats = {{256, 0.1, 0.3, 0.3, 1.0, 0.3}};
  const HairTexture texture = make_hair_texture(options);
  Progress progress;
  const Transfer transfer = make_transfer(texture, {3, 64, 0.0}, progress);
  const PlaceLight light = light_of(3, {{Vector3d(0.3, 0.2, 0.9).normalized(), {3.0, 2.0, 1.0}}});
  const Vector3d eye(5.0, -8.0, 32.0), target(8.0, 8.0, 0.0);
  device::Context& context = device::Context::chosen("auto");
  constexpr int columns = 37, rows = 41;
  DeviceFrame frame(context, texture, transfer, HairColour{}, columns, rows);
  frame.light(light, (eye - target).normalized(), HairReflectance(HairModel::kajiya_kay));
  frame.draw(eye, target, 8.0, true);
  EXPECT_EQ(frame.rays_apart(), 1);
  const Image<float> every = frame.picture();
  frame.draw(eye, target, 8.0);
  EXPECT_EQ(frame.rays_apart(), 2);
  const Image<float> between = frame.picture();
  double difference = 0.0, sum = 0.0;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const double here = every(x, y, 0), off = std::abs(between(x, y, 0) - here);
      if (x % 2 == 0 && y % 2 == 0) {
        // Its ray is the same, in another group of pixels: each picture errs by as much.
        EXPECT_LE(off, 2.0 * (of_light * here + of_white * frame.white())) << x << ", " << y;
      }
      difference += off;
      sum += here;
    }
  }
  EXPECT_LT(difference, 0.02 * sum);
  EXPECT_GT(difference, 0.0);
  frame.draw(eye, target, 35.0);  // texels of two pixels
  EXPECT_EQ(frame.rays_apart(), 1);
}

}  // namespace

}  // namespace kappamu::forward::shells
