// Diffusion or transport, by the measured error of the one (docs/validity.md) and the data's own.
// What transport then brings is tests/inverse/fit/transport_fit_test.cpp's.
#include "inverse/data_checks/physics_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace kappamu::inverse {
namespace {

using ::testing::HasSubstr;

/// A block of edge 0.5 mm voxels, `depth` of them, whose data have the relative deviation `noise`.
Problem problem_of(int depth, double noise, Face seen = Face::z_plus) {
  Problem p;
  p.setup.shape = {8, 8, depth, 0.5};
  p.seen_face = seen;
  p.patterns = 1;
  p.data.assign(p.seen_shape().cells(), 0.2);
  p.weight.assign(p.data.size(), std::pow(noise * 0.2, -2));
  p.weight.front() = 0.0;
  return p;
}

Physics taken(const Problem& p, double kappa, double mu) {
  return choose_physics(p, kappa, mu).physics;
}

TEST(PhysicsChoice, ThinAndAbsorbingBlocksNeedTransportAndThickClearOnesDoNot) {
  constexpr double kappa = 1.0 / 3.0, clear = 0.001;  // mean free path 1 mm
  constexpr double noise = 0.02;
  EXPECT_EQ(taken(problem_of(4, noise), kappa, clear), Physics::transport);   // 2 of them: 11 %
  EXPECT_EQ(taken(problem_of(32, noise), kappa, clear), Physics::diffusion);  // 16: 1 %
  EXPECT_EQ(taken(problem_of(32, noise), kappa, 0.1), Physics::transport);    // albedo 0.9: 8 %
}

TEST(PhysicsChoice, TheDatasOwnErrorDecides) {
  constexpr double kappa = 1.0 / 3.0, mu = 0.001;
  // Four mean free paths: 3.1 % on the far face's map.
  EXPECT_EQ(taken(problem_of(8, 0.02), kappa, mu), Physics::transport);
  EXPECT_EQ(taken(problem_of(8, 0.05), kappa, mu), Physics::diffusion);
  // The lit face's total is 1.2 % off there.
  EXPECT_EQ(taken(problem_of(8, 0.02, Face::z_minus), kappa, mu), Physics::diffusion);
  EXPECT_EQ(taken(problem_of(8, 0.005, Face::z_minus), kappa, mu), Physics::transport);
}

TEST(PhysicsChoice, SaysWhyInOneSentence) {
  const std::string reason = choose_physics(problem_of(4, 0.02), 1.0 / 3.0, 0.001).reason;
  EXPECT_EQ(
      reason,
      "Diffusion errs by about 11 % in a slab like this block (albedo 0.999, 2 transport mean free "
      "paths thick), the data by 2 %: the fit is by transport.");
  EXPECT_THAT(choose_physics(problem_of(32, 0.02), 1.0 / 3.0, 0.001).reason,
              HasSubstr("the fit is by diffusion."));
}

TEST(PhysicsChoice, WhereNothingComesThroughWhatIsReflectedAnswers) {
  // Albedo 0.5, 32 mean free paths: the table knows the reflected total alone.
  EXPECT_EQ(taken(problem_of(64, 0.02), 1.0 / 3.0, 0.5), Physics::transport);
  EXPECT_EQ(taken(problem_of(64, 0.5), 1.0 / 3.0, 0.5), Physics::diffusion);
}

}  // namespace
}  // namespace kappamu::inverse
