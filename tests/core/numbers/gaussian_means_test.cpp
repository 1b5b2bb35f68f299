// Gaussian means over a block: what they keep, what they take away, and where they begin to count.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/numbers/gaussian_sum.h"

namespace kappamu {
namespace {

constexpr GridShape shape{48, 5, 4, 0.5};

Volume<double> wave_along_x(double half_periods) {
  Volume<double> field(shape);
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        field(x, y, z) = 1.0 + std::cos(std::numbers::pi * half_periods * (x + 0.5) / shape.nx);
      }
    }
  }
  return field;
}

TEST(GaussianMeans, KeepWhatIsEvenAndPassHalfOfTheWaveOfTheirWidth) {
  constexpr double half_periods = 12.0;
  const double wavenumber = std::numbers::pi * half_periods / (shape.nx * shape.voxel_mm);
  const double fwhm = 4.0 * std::numbers::ln2 / wavenumber;  // exp(-k² w²/2) = 1/2
  const Volume<double> means =
      gaussian_means(wave_along_x(half_periods), Face::z_minus, {fwhm, fwhm, 0.0, 1e6});
  const Volume<double> field = wave_along_x(half_periods);
  const int x = 24;  // far from both ends
  EXPECT_NEAR(means(x, 2, 0) - 1.0, 0.5 * (field(x, 2, 0) - 1.0), 0.01);
  EXPECT_EQ(means(x, 2, 2), field(x, 2, 2)) << "no width, no mean";
  for (int at = 0; at < shape.nx; ++at) EXPECT_NEAR(means(at, 2, 3), 1.0, 1e-6);
}

TEST(GaussianMeans, CountLayersFromTheFaceAndMixThemAlongTheDepth) {
  Volume<double> field(shape);
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) field(x, y, z) = z;
    }
  }
  const double fwhm = 2.0 * shape.voxel_mm;  // a neighbour counts 2^(-1), the next 2^(-4)
  const Volume<double> means = gaussian_means(field, Face::z_plus, {0.0, 0.0, 0.0, fwhm});
  const double weights = 1.0 + 0.5 + std::pow(2.0, -4) + std::pow(2.0, -9);
  EXPECT_NEAR(means(3, 3, 0), (0.5 + 2.0 * std::pow(2.0, -4) + 3.0 * std::pow(2.0, -9)) / weights,
              1e-12);
  EXPECT_EQ(means(3, 3, 3), 3.0);
}

}  // namespace
}  // namespace kappamu
