#include "core/appearance_error.h"

#include <gtest/gtest.h>

namespace kappamu {
namespace {

TEST(AppearanceError, FollowsItsDefinition) {
  AppearanceError error;
  error.add(4.0, 3.0, 0.25);
  error.add(0.0, 1.0, 0.75);
  EXPECT_DOUBLE_EQ(error.E(), 2.0 / 10.0);
  EXPECT_DOUBLE_EQ(error.noise_E(), 1.0 / 10.0);
  EXPECT_EQ(error.count, 2U);
}

TEST(AppearanceError, IsThatOfAllPartsTogether) {
  AppearanceError bright, dim, all;
  bright.add(110.0, 100.0, 1.0);
  dim.add(2.0, 1.0, 1.0);
  all.add(bright);
  all.add(dim);
  EXPECT_DOUBLE_EQ(all.E(), 101.0 / 10001.0);
  EXPECT_DOUBLE_EQ(all.noise_E(), 2.0 / 10001.0);
  EXPECT_EQ(all.count, 2U);
}

TEST(AppearanceError, DoesNotDependOnTheUnitOfLight) {
  AppearanceError watts, kilowatts;
  for (const double light : {1.0, 2.0, 5.0}) {
    watts.add(1000.0 * 1.1 * light, 1000.0 * light, 1e6 * 0.01);
    kilowatts.add(1.1 * light, light, 0.01);
  }
  EXPECT_NEAR(watts.E(), kilowatts.E(), 1e-15);
  EXPECT_NEAR(watts.noise_E(), kilowatts.noise_E(), 1e-15);
}

TEST(AppearanceError, WithoutLightIsZero) {
  AppearanceError error;
  error.add(1.0, 0.0);
  EXPECT_EQ(error.E(), 0.0);
  EXPECT_EQ(error.noise_E(), 0.0);
}

}  // namespace
}  // namespace kappamu
