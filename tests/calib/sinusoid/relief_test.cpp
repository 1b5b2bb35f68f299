// A surface of known height under a pinhole projector, whose rays are cut with the plane.
#include "calib/sinusoid/relief.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"

namespace kappamu::calib {
namespace {

constexpr int width = 160, height = 120;
constexpr double pixel_mm = 0.25, two_pi = 2.0 * std::numbers::pi;
// Fringes across the picture's diagonal; the dome reaches over more than one period of height.
const FringeProjector projector{-25.0, 350.0, 0.25, 0.6};

struct Point {
  double x = 0.0, y = 0.0, z = 0.0;
};

double surface(double x, double y) {
  return 10.0 * std::exp(-(x * x + y * y) / 100.0) - 0.05 * x;
}

Point place_of_projector() {
  const double angle = projector.degrees * std::numbers::pi / 180.0;
  const double along = projector.distance_mm * std::sin(angle);
  return {along * std::cos(projector.direction), along * std::sin(projector.direction),
          projector.distance_mm * std::cos(angle)};
}

/// Where the plane would be lit: cycles of the fringes there.
double cycles(double x, double y) {
  const Point p = place_of_projector();
  const double t = p.z / (p.z - surface(x, y));
  const double on_x = p.x + t * (x - p.x), on_y = p.y + t * (y - p.y);
  return projector.per_mm *
         (on_x * std::cos(projector.direction) + on_y * std::sin(projector.direction));
}

double irradiance(double x, double y, double z, double slope_x, double slope_y) {
  const Point p = place_of_projector();
  const double dx = p.x - x, dy = p.y - y, dz = p.z - z;
  return (dz - slope_x * dx - slope_y * dy) / std::hypot(1.0, slope_x, slope_y) /
         std::pow(std::hypot(dx, dy, dz), 3.0);
}

TEST(Relief, HeightsLightAndFrequencyAreThoseOfTheRays) {
  Image<float> sample(width, height, 1), plane(width, height, 1);
  const auto at = [](int i, int n) { return (i - 0.5 * (n - 1)) * pixel_mm; };
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const double x = at(i, width), y = at(j, height);
      const double flat = projector.per_mm *
                          (x * std::cos(projector.direction) + y * std::sin(projector.direction));
      sample(i, j) = static_cast<float>(std::remainder(two_pi * cycles(x, y), two_pi));
      plane(i, j) = static_cast<float>(std::remainder(two_pi * flat, two_pi));
    }
  }
  Image<std::uint8_t> mask(width, height, 1, 1);
  mask(5, 5) = 0;
  const Relief relief = measure_relief(sample, plane, mask, projector, pixel_mm, 1.0);
  EXPECT_EQ(relief.height_mm(5, 5), 0.0F);
  constexpr double d = 1e-3;
  for (int j = 8; j < height - 8; j += 13) {
    for (int i = 8; i < width - 8; i += 17) {
      const double x = at(i, width), y = at(j, height), z = surface(x, y);
      ASSERT_NEAR(relief.height_mm(i, j), z, 2e-3) << i << " " << j;
      const double slope_x = (surface(x + d, y) - surface(x - d, y)) / (2.0 * d);
      const double slope_y = (surface(x, y + d) - surface(x, y - d)) / (2.0 * d);
      ASSERT_NEAR(relief.irradiance(i, j),
                  irradiance(x, y, z, slope_x, slope_y) / irradiance(x, y, 0.0, 0.0, 0.0), 5e-3);
      const double c = std::cos(projector.direction), s = std::sin(projector.direction);
      const double along =
          (cycles(x + d * c, y + d * s) - cycles(x - d * c, y - d * s)) / (2.0 * d);
      ASSERT_NEAR(relief.frequency(i, j),
                  along / std::hypot(1.0, slope_x * c + slope_y * s) / projector.per_mm, 5e-3);
    }
  }
}

TEST(Relief, AProjectorAlongTheAxisIsRefused) {
  const Image<float> phase(4, 4, 1);
  EXPECT_THROW(measure_relief(phase, phase, Image<std::uint8_t>(4, 4, 1, 1), {0.2, 300.0, 0.2, 0.0},
                              0.3, 1.0),
               InputError);
}

}  // namespace
}  // namespace kappamu::calib
