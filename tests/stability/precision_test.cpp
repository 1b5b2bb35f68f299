// What float and double can attain, and absorption from none to all.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/forward/analytic/slab.h"
#include "tests/stability/bounds.h"
#include "tests/stability/stability_tools.h"

namespace kappamu::test_cases {
namespace {

using forward::Precision;
using forward::SourceModel;
using forward::Termination;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

class Floor : public testing::OnDevice, public ::testing::WithParamInterface<double> {};

LimitCase out_of_reach(double contrast, Precision precision) {
  return {.setup = {.shape = {24, 24, 12, 0.25}},
          .medium = {.kind = MediumKind::inclusions, .contrast = contrast},
          .options = {1e-16, 200},
          .precision = precision};
}

TEST_P(Floor, FloatKeepsSixDigitsAtAnyContrastAndNamesDouble) {
  const LimitOutcome outcome = run_limit(out_of_reach(GetParam(), Precision::single_precision));
  EXPECT_LT(*outcome.true_error, bounds::single_floor);
  EXPECT_EQ(outcome.termination, Termination::ran_out);
  EXPECT_THAT(outcome.message, HasSubstr("tolerance 1e-16 not met"));
  EXPECT_THAT(outcome.message, HasSubstr("single precision's floor"));
  EXPECT_THAT(outcome.message, HasSubstr("double precision goes lower"));
}

TEST_P(Floor, DoubleKeepsThirteen) {
  const LimitOutcome outcome = run_limit(out_of_reach(GetParam(), Precision::double_precision));
  EXPECT_LT(*outcome.true_error, bounds::double_floor);
  EXPECT_EQ(outcome.termination, Termination::ran_out);
  EXPECT_THAT(outcome.message, HasSubstr("tolerance 1e-16 not met"));
  EXPECT_THAT(outcome.message, HasSubstr("double precision's floor"));
  EXPECT_THAT(outcome.message, Not(HasSubstr("double precision goes lower")));
}

INSTANTIATE_TEST_SUITE_P(, Floor, ::testing::Values(1e1, 1e4, 1e6));

class AbsorptionEdge : public testing::OnDevice {};
class Absorption : public testing::OnDevice, public ::testing::WithParamInterface<double> {};

LimitCase absorbing(double mu) {
  return {
      .setup = {.shape = {8, 8, 20, 0.25}, .sides = Sides::mirror, .source = SourceModel::boundary},
      .medium = {.mean_kappa = 0.3, .mu = mu}};
}

TEST_P(Absorption, LeavesEnergyBalancedAndTheFluenceRight) {
  const LimitOutcome outcome = run_limit(absorbing(GetParam()));
  EXPECT_EQ(outcome.termination, Termination::converged) << outcome.message;
  EXPECT_LE(outcome.iterations, 12);
  EXPECT_LT(*outcome.true_error, bounds::single_error);
  EXPECT_LT(outcome.imbalance, bounds::imbalance);
}

INSTANTIATE_TEST_SUITE_P(, Absorption,
                         ::testing::Values(0.0, 1e-9, 1e-6, 1e-3, 0.1, 1.0, 10.0, 100.0));

TEST_F(AbsorptionEdge, ModerateMatchesTheClosedSlab) {
  constexpr double kappa = 0.3, mu = 0.1;
  const LimitOutcome outcome = run_limit(absorbing(mu));
  const BoundaryConstants constants = boundary_constants(1.3);
  const double exact = forward::slab_boundary({kappa, mu, 5.0}, constants, 1.0).exitance_far() /
                       constants.normal_transmittance;
  // h² of the grid at 7 voxels per penetration depth; order 2 is grid_order_test's.
  EXPECT_NEAR(outcome.transmitted, exact, 5e-3 * exact);
}

/// Five decades below the source float at 1e-6 is blind, and double with a tolerance that deep
/// sees.
TEST_F(AbsorptionEdge, DarkFacesNeedADeeperTolerance) {
  LimitCase limit = absorbing(10.0);
  const LimitOutcome blind = run_limit(limit);
  EXPECT_GT(*blind.dark_error, 0.1);
  limit.options.tolerance = 1e-13;
  limit.precision = Precision::double_precision;
  const LimitOutcome seeing = run_limit(limit);
  EXPECT_LT(*seeing.dark_error, 0.02);
}

TEST_F(AbsorptionEdge, WithoutScatteringThereIsNoSourceAndTheProgramSaysWhy) {
  LimitCase limit = absorbing(2.0);  // 3κμ = 1.8
  limit.setup.source = SourceModel::first_collision;
  const LimitOutcome outcome = run_limit(limit);
  EXPECT_EQ(outcome.termination, Termination::converged);
  EXPECT_EQ(*outcome.true_error, 0.0);
  EXPECT_LT(outcome.imbalance, bounds::imbalance);  // absorbed at once, and counted
  ASSERT_FALSE(outcome.warnings.empty());
  EXPECT_THAT(outcome.warnings, Contains(HasSubstr("no scattering is left")));
}

}  // namespace
}  // namespace kappamu::test_cases
