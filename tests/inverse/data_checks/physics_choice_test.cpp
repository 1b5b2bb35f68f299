// Diffusion or transport, by the homogeneous blocks that both find. What transport then brings is
// tests/inverse/fit/transport_fit_test.cpp's.
#include "inverse/data_checks/physics_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "device/device_info.h"
#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse {
namespace {

using ::testing::EndsWith;

constexpr double kappa = 0.3, mu = 0.01;

class PhysicsChoiceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  }

  /// Of a block lit all over, of voxels of 0.4 mm, 10 of them deep, by diffusion.
  static PhysicsChoice chosen(int across, Sides sides, double uncertain) {
    return choose_physics(lit(across, sides, 2), start(uncertain), Backend{}, PhotonOptions{});
  }

  static HomogeneousFit start(double uncertain) {
    HomogeneousFit start;
    start.kappa = kappa;
    start.mu = mu;
    start.deviation.setConstant(uncertain);
    return start;
  }

  static Problem lit(int across, Sides sides, int patterns) {
    cases::Noise noise(3);
    Problem problem = cases::randomly_lit({across, across, 10, 0.4}, patterns, noise);
    problem.setup.sides = sides;
    problem.irradiance.assign(problem.irradiance.size(), 1.0);
    const GridShape& shape = problem.setup.shape;
    const CoefficientPair truth{std::vector<double>(shape.cells(), std::log(kappa)),
                                std::vector<double>(shape.cells(), std::log(mu))};
    problem.data = cases::simulate(problem.setup, truth, problem.seen_face, problem.irradiance,
                                   problem.patterns, "reference");
    for (const double d : problem.data) problem.weight.push_back(std::pow(0.02 * d, -2));
    return problem;
  }
};

// A slab of 4.4 mean free paths: what passes is right to 1 %.
TEST_F(PhysicsChoiceTest, StaysWithDiffusionWhereTransportFindsTheSameBlock) {
  const PhysicsChoice choice = chosen(6, Sides::mirror, 0.0);
  EXPECT_EQ(choice.physics, Physics::diffusion) << choice.reason;
  EXPECT_THAT(choice.reason, EndsWith("the fit is by diffusion."));
  EXPECT_GT(choice.solves.photons, 0.0);
}

// Every other pattern is dark, those among them that lie evenly in the sequence.
TEST_F(PhysicsChoiceTest, AsksBrightPatterns) {
  Problem problem = lit(6, Sides::mirror, 8);
  const auto darken = [](std::vector<double>& values, std::size_t cells) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i / cells % 2 == 1) values[i] = 0.0;
    }
  };
  darken(problem.irradiance, problem.lit_shape().cells());
  darken(problem.data, problem.seen_shape().cells());
  darken(problem.weight, problem.seen_shape().cells());
  EXPECT_NO_THROW(choose_physics(problem, start(0.0), Backend{}, PhotonOptions{}));
}

// A rod 2.7 mean free paths across: light leaves by its sides.
TEST_F(PhysicsChoiceTest, TakesTransportWhereItFindsAnother) {
  const PhysicsChoice choice = chosen(6, Sides::open, 0.0);
  EXPECT_EQ(choice.physics, Physics::transport) << choice.reason;
  EXPECT_THAT(choice.reason, EndsWith("the fit is by transport."));
}

TEST_F(PhysicsChoiceTest, AnErrorBelowWhatStructureLeavesUncertainIsNone) {
  EXPECT_EQ(chosen(6, Sides::open, 10.0).physics, Physics::diffusion);
}

}  // namespace
}  // namespace kappamu::inverse
