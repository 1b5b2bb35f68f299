// The measured table of diffusion's errors, as the program reads it. That the table is true is
// `kappamu-studies validity`'s business.
#include "forward/analytic/validity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace kappamu::forward {
namespace {

GridSetup setup_of(int nz) {
  GridSetup setup;
  setup.shape = {4, 4, nz, 1.0};
  return setup;
}
Medium medium_of(const GridSetup& setup, double albedo) {
  // One mean free path per voxel.
  return {Volume<double>(setup.shape, 1.0 / 3.0), Volume<double>(setup.shape, 1.0 - albedo)};
}

TEST(Validity, DiffusionFailsWithAbsorptionAndThinness) {
  double last = 1.0;
  for (const double albedo : {0.5, 0.65, 0.8, 0.9, 0.95, 0.99, 0.999}) {
    const auto reflected = diffusion_validity(albedo, 16.0).reflected;
    ASSERT_TRUE(reflected);
    EXPECT_LT(std::abs(*reflected), last) << albedo;
    last = std::abs(*reflected);
  }
  const auto thin = diffusion_validity(0.99, 1.0).far_map,
             thick = diffusion_validity(0.99, 4.0).far_map;
  ASSERT_TRUE(thin && thick);
  EXPECT_GT(*thin, 3.0 * *thick);
}

TEST(Validity, IsContinuousAndEndsAtTheTablesEdges) {
  for (const double paths : {1.5, 4.0, 7.9, 8.1}) {
    for (const double albedo : {0.6, 0.9, 0.993}) {
      const double here = diffusion_validity(albedo, paths).reflected.value();
      const double beside = diffusion_validity(albedo + 1e-9, paths * (1 + 1e-9)).reflected.value();
      EXPECT_NEAR(here, beside, 1e-6);
    }
  }
  EXPECT_EQ(diffusion_validity(1.0, 8.0).reflected, diffusion_validity(0.999, 8.0).reflected);
  EXPECT_EQ(diffusion_validity(0.1, 8.0).reflected, diffusion_validity(0.5, 8.0).reflected);
  EXPECT_EQ(diffusion_validity(0.9, 0.1).reflected, diffusion_validity(0.9, 1.0).reflected);
}

TEST(Validity, IsSilentWhereNothingWasResolved) {
  EXPECT_FALSE(diffusion_validity(0.5, 50.0).transmitted);
  EXPECT_TRUE(diffusion_validity(0.5, 50.0).reflected);
}

TEST(Validity, WarnsWithNumbersAndOnlyWhereNeeded) {
  const GridSetup thick = setup_of(16), thin = setup_of(1);
  EXPECT_FALSE(validity_warning(thick, medium_of(thick, 0.999)));
  const auto absorbing = validity_warning(thick, medium_of(thick, 0.8));
  ASSERT_TRUE(absorbing);
  EXPECT_THAT(*absorbing, ::testing::HasSubstr("albedo 0.8, 16 transport mean free paths"));
  EXPECT_THAT(*absorbing, ::testing::HasSubstr("% in the light reflected"));
  EXPECT_TRUE(validity_warning(thin, medium_of(thin, 0.999)));
  EXPECT_FALSE(validity_warning(thin, medium_of(thin, 0.999), 0.5));
}

}  // namespace
}  // namespace kappamu::forward
