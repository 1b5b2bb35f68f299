// The serial reference on cases small enough to work out by hand. Laws that every backend must
// obey are in grid_laws_test.cpp.
#include <gtest/gtest.h>

#include "forward/grid/grid_solver.h"
#include "tests/forward/grid/test_tools.h"

namespace kappamu::forward {
namespace {

using testing::Values;

constexpr double rounding = 1e-13;  // a few operations in double

TEST(ReferenceSolver, SingleCellIsABalanceOfOneLine) {
  GridSetup setup{.shape = {1, 1, 1, 0.5}, .source = SourceModel::boundary};
  const auto solver = make_reference_solver(setup);
  const double kappa = 0.2, mu = 0.3, h = 0.5, e = 0.7;
  solver->set_medium(Values{kappa}, Values{mu});
  const auto& c = solver->constants();
  const double g = h * h / (h / (2 * kappa) + 2 * c.A);
  const double q = 4 * c.normal_transmittance * e / (1 - c.r_phi);
  const auto solution = testing::solve_light(*solver, {e}, 1, {1e-12, 10});
  const double phi = testing::read(*solver, *solution.phi)[0];
  EXPECT_NEAR(phi, g * q / (6 * g + mu * h * h * h), rounding * phi);
  EXPECT_NEAR(testing::exitance(*solver, *solution.phi, Face::z_plus, {})[0], g * phi / (h * h),
              rounding);
}

TEST(ReferenceSolver, TwoCellsHaveTheHarmonicMeanBetweenThem) {
  GridSetup setup{.shape = {2, 1, 1, 1.0}, .sides = Sides::mirror};
  const auto solver = make_reference_solver(setup);
  const double k0 = 0.1, k1 = 0.4;
  solver->set_medium(Values{k0, k1}, Values{0.0, 0.0});
  const auto phi = solver->make_field(1);
  const auto y = solver->make_field(1);
  solver->fill(*phi, Values{1.0, 0.0});
  solver->apply(*phi, *y);
  EXPECT_NEAR(testing::read(*solver, *y)[1], -2 * k0 * k1 / (k0 + k1), rounding);
}

TEST(ReferenceSolver, ConvergesOnAJumpyMedium) {
  GridSetup setup{.shape = {32, 29, 11, 0.5}};
  const auto solver = make_reference_solver(setup);
  const auto medium = testing::random_medium(setup.shape, 1e4, 1);
  solver->set_medium(medium.kappa, medium.mu);
  const auto solution = testing::solve_light(
      *solver, testing::random_values(std::size_t{32} * 29 * 2, 0, 1, 2), 2, {1e-10, 400});
  EXPECT_EQ(solution.report.termination, Termination::converged) << solution.report.message;
}

}  // namespace
}  // namespace kappamu::forward
