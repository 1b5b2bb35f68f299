// What `kappamu check-gradient` runs holds on honest data, and its verdict can fail.
#include "inverse/data_checks/gradient_check.h"

#include <gtest/gtest.h>

#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse {
namespace {

Problem small_problem() {
  Problem problem;
  problem.setup.shape = {7, 6, 4, 0.4};
  problem.patterns = 2;
  cases::Noise noise(3);
  for (std::size_t i = 0; i < 2 * problem.lit_shape().cells(); ++i) {
    problem.irradiance.push_back(noise.uniform());
  }
  for (std::size_t i = 0; i < 2 * problem.seen_shape().cells(); ++i) {
    problem.data.push_back(0.1 + 0.02 * noise.uniform());
    problem.weight.push_back(i % 5 == 0 ? 0.0 : 1e4);
  }
  return problem;
}

TEST(GradientCheck, HoldsOnTheReferenceAndOnTheDevice) {
  for (const std::string device : {"reference", "auto"}) {
    const GradientCheck check = check_gradient(small_problem(), device, 1);
    EXPECT_TRUE(check.taylor_holds()) << check.worst_order_error << " on " << check.backend;
    EXPECT_TRUE(check.adjoint_holds()) << check.adjoint_error << " on " << check.backend;
    EXPECT_TRUE(check.symmetry_holds()) << check.symmetry_error << " on " << check.backend;
    EXPECT_GT(std::abs(check.directional_derivative), 0.0);
    ASSERT_EQ(check.taylor.size(), 4U);
  }
}

TEST(GradientCheck, VerdictFollowsTheFigures) {
  GradientCheck check;
  EXPECT_FALSE(check.taylor_holds()) << "nothing measured is no pass";
  check.taylor.resize(4);
  EXPECT_TRUE(check.holds());
  check.worst_order_error = 0.06;
  EXPECT_FALSE(check.holds());
  check.worst_order_error = std::nan("");
  EXPECT_FALSE(check.holds());
  check.worst_order_error = 0.0;
  check.adjoint_error = 1e-5;
  EXPECT_FALSE(check.holds());
  check.adjoint_error = 0.0;
  check.symmetry_error = 1e-8;
  EXPECT_FALSE(check.holds());
}

}  // namespace
}  // namespace kappamu::inverse
