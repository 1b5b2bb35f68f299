#include "calib/lens/lens.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace kappamu::calib {
namespace {

Lens wide_lens() {
  return {640, 480, 532.8, 532.9, 342.5, 233.9, {-0.2809, 0.0252, 0.0012, -0.0001, 0.1634}};
}

// Promise of Lens::unproject.
constexpr double unproject_tolerance_px = 1e-9;

TEST(Lens, UnprojectInvertsProjectOverTheWholeFrame) {
  const Lens lens = wide_lens();
  for (int y = 0; y <= lens.height; y += 24) {
    for (int x = 0; x <= lens.width; x += 32) {
      const Eigen::Vector2d pixel(x - 0.5, y - 0.5);
      const Eigen::Vector3d ray = lens.unproject(pixel);
      EXPECT_EQ(ray.z(), 1.0);
      EXPECT_LT((lens.project(ray) - pixel).norm(), unproject_tolerance_px) << x << " " << y;
    }
  }
}

TEST(Lens, ProjectionIsConstantAlongARay) {
  const Lens lens = wide_lens();
  const Eigen::Vector3d point(31.0, -17.0, 210.0);
  EXPECT_LT((lens.project(point) - lens.project(3.7 * point)).norm(), unproject_tolerance_px);
}

TEST(Lens, AxisMeetsThePrincipalPoint) {
  const Lens lens = wide_lens();
  EXPECT_EQ(lens.project({0.0, 0.0, 5.0}), Eigen::Vector2d(lens.cx, lens.cy));
}

TEST(Lens, WithoutDistortionItIsThePinhole) {
  const Lens lens{100, 80, 90.0, 95.0, 49.5, 39.5, {}};
  const Eigen::Vector2d pixel = lens.project({1.0, -2.0, 10.0});
  EXPECT_DOUBLE_EQ(pixel.x(), 90.0 * 0.1 + 49.5);
  EXPECT_DOUBLE_EQ(pixel.y(), 95.0 * -0.2 + 39.5);
}

TEST(Lens, RadialDistortionCommutesWithRotationAboutTheAxis) {
  Lens lens = wide_lens();
  lens.fy = lens.fx;
  lens.distortion[2] = lens.distortion[3] = 0.0;
  const Eigen::Vector2d centre(lens.cx, lens.cy);
  const Eigen::Vector3d point(40.0, 25.0, 120.0);
  const Eigen::Rotation2Dd turn(0.7);
  Eigen::Vector3d turned = point;
  turned.head<2>() = turn * point.head<2>();
  EXPECT_LT((lens.project(turned) - centre - turn * (lens.project(point) - centre)).norm(),
            unproject_tolerance_px);
}

TEST(Lens, ContainsCountsThePixelsNotTheirCentres) {
  const Lens lens{10, 8, 1.0, 1.0, 0.0, 0.0, {}};
  EXPECT_TRUE(lens.contains({-0.4, -0.4}));
  EXPECT_TRUE(lens.contains({9.4, 7.4}));
  EXPECT_FALSE(lens.contains({9.6, 0.0}));
  EXPECT_FALSE(lens.contains({0.0, 0.0}, 1.0));
}

}  // namespace
}  // namespace kappamu::calib
