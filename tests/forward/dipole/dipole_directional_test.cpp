// The directional dipole over a half-space: how much leaves, and where, against what transport
// makes of first collisions.
#include "forward/dipole/directional.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kappamu::forward::dipole {
namespace {

/// Total exitance of the plane z = 0 from light that enters at the origin, and its mean place.
struct PlaneMoments {
  double total = 0.0, x = 0.0;
};

PlaneMoments moments(const DirectionalDipole& dipole, const Eigen::Vector3d& direction) {
  constexpr int rings = 400, turns = 64;
  constexpr double shortest = -9.0, longest = 6.0;  // of ln r, in mm
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  PlaneMoments sum;
  for (int i = 0; i < rings; ++i) {
    const double r = std::exp(shortest + (longest - shortest) * (i + 0.5) / rings);
    for (int j = 0; j < turns; ++j) {
      const double angle = 2.0 * std::numbers::pi * (j + 0.5) / turns;
      const Eigen::Vector3d to(r * std::cos(angle), r * std::sin(angle), 0.0);
      const double part = r * r * (longest - shortest) / rings * 2.0 * std::numbers::pi / turns *
                          dipole.value(Eigen::Vector3d::Zero(), up, direction, to, up);
      sum.total += part;
      sum.x += part * to.x();
    }
  }
  sum.x /= sum.total;
  return sum;
}

/// Reflected light of a half-space of α' = 0.99 and η = 1 under light along the normal is 0.757
/// (H-functions, dipole_profile_test).
TEST(DirectionalDipole, ReflectsNearlyWhatTransportDoes) {
  const DirectionalDipole dipole({1.0 / 3.0, 0.01}, boundary_constants(1.0));
  EXPECT_NEAR(moments(dipole, -Eigen::Vector3d::UnitZ()).total / 0.757, 1.0, 0.1);
}

TEST(DirectionalDipole, SendsSlantedLightAhead) {
  const DirectionalDipole dipole({1.0 / 3.0, 0.01}, boundary_constants(1.3));
  const double sine = 0.6;
  const PlaneMoments straight = moments(dipole, -Eigen::Vector3d::UnitZ());
  const PlaneMoments slanted = moments(dipole, {sine, 0.0, -0.8});
  EXPECT_NEAR(straight.x, 0.0, 1e-9);
  // All light that leaves has its first collision a mean free path, here 1 mm, along the ray.
  EXPECT_NEAR(slanted.x / sine, 1.0, 0.4);
  EXPECT_NEAR(slanted.total / straight.total, 1.0, 0.15);
}

TEST(DirectionalDipole, ScalesWithTheUnitOfLength) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ(), to(0.7, 0.2, -0.1), ray(0.6, 0.0, -0.8);
  const DirectionalDipole one({0.2, 0.03}, boundary_constants(1.3));
  const DirectionalDipole ten({2.0, 0.003}, boundary_constants(1.3));
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  EXPECT_NEAR(
      100.0 * ten.value(origin, up, ray, 10.0 * to, up) / one.value(origin, up, ray, to, up), 1.0,
      1e-12);
}

}  // namespace
}  // namespace kappamu::forward::dipole
