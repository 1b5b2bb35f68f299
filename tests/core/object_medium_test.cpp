// Where two media of an object differ.
#include "core/object_medium.h"

#include <gtest/gtest.h>

namespace kappamu {
namespace {

using Eigen::Vector3d;

struct Volumes {
  GridShape shape{10, 8, 6, 0.5};
  Eigen::Affine3d place = Eigen::Translation3d(1.0, 2.0, 3.0) *
                          Eigen::AngleAxisd(0.3, Vector3d::UnitZ()) * Eigen::Scaling(2.0);

  Medium even() const { return {Volume<double>(shape, 0.2), Volume<double>(shape, 0.02)}; }
  ObjectMedium placed(const Medium& medium, Wrap wrap = Wrap::clamp) const {
    return {std::make_shared<Medium>(medium), place, wrap};
  }
};

/// Points of the object all around the volume.
template <class Visit>
void each_point(const Visit& visit) {
  for (double z = -8.0; z < 8.0; z += 0.31) {
    for (double y = -8.0; y < 8.0; y += 0.33) {
      for (double x = -8.0; x < 8.0; x += 0.35) visit(Vector3d(x, y, z));
    }
  }
}

TEST(ObjectMediumDifference, HoldsEveryPointWhereMediaDiffer) {
  const Volumes volumes;
  Medium inside = volumes.even(), at_border = volumes.even();
  for (const int x : {4, 5}) inside.kappa[volumes.shape.index(x, 3, 2)] = 0.9;
  at_border.mu[volumes.shape.index(0, 7, 3)] = 0.5;  // clamped: it goes on beyond the volume
  const ObjectMedium before = volumes.placed(volumes.even());
  for (const Medium& edited : {inside, at_border}) {
    const ObjectMedium after = volumes.placed(edited);
    const Eigen::AlignedBox3d box = after.difference(before);
    int differ = 0, outside = 0;
    each_point([&](const Vector3d& p) {
      const Coefficients a = before.at(p), b = after.at(p);
      if (a.kappa == b.kappa && a.mu == b.mu) return;
      ++differ;
      outside += box.contains(p) ? 0 : 1;
    });
    EXPECT_GT(differ, 0);
    EXPECT_EQ(outside, 0);
  }
  const Eigen::AlignedBox3d box = volumes.placed(inside).difference(before);
  EXPECT_LE(box.sizes().maxCoeff(), 2.0);  // two voxels of 0.25 mm in the object, turned
}

TEST(ObjectMediumDifference, IsNothingOfEqualMediaAndAllOfThosePlacedOtherwise) {
  const Volumes volumes;
  const ObjectMedium one = volumes.placed(volumes.even());
  EXPECT_TRUE(one.difference(one).isEmpty());
  EXPECT_TRUE(volumes.placed(volumes.even()).difference(one).isEmpty());
  EXPECT_TRUE(ObjectMedium({0.2, 0.1}).difference(ObjectMedium({0.2, 0.1})).isEmpty());
  const Vector3d far = Vector3d::Constant(1e6);
  EXPECT_TRUE(ObjectMedium({0.2, 0.1}).difference(ObjectMedium({0.2, 0.2})).contains(far));
  EXPECT_TRUE(one.difference(ObjectMedium({0.2, 0.02})).contains(far));
  EXPECT_TRUE(volumes.placed(volumes.even(), Wrap::repeat).difference(one).contains(far));
  Volumes moved;
  moved.place.translate(Vector3d(0.1, 0.0, 0.0));
  EXPECT_TRUE(moved.placed(moved.even()).difference(one).contains(far));
}

}  // namespace
}  // namespace kappamu
