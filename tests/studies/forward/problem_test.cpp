// What true errors are measured against, and the matrix that peers are given. That the peers solve
// that matrix is in peer_test.cpp.
#include "studies/forward/problem.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "studies/forward/measure.h"
#include "tests/cases/limit_case.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

ProblemSpec small(int patterns = 3) {
  return {"small", {13, 9, 6, 0.25}, reference_inclusions(), patterns, patterns};
}

TEST(BenchProblem, TruthIsThatOfTheReferenceRefinedInLongDouble) {
  const Problem problem(small(), "auto");
  const auto truth = converged_fluence(problem.setup(), problem.medium(), problem.irradiance(), 3);
  // Contrast 1e5 times a residual of 1e-13 bounds it by 1e-8; multigrid's residual is far better
  // spread than the worst case.
  constexpr double tolerance = 1e-11;
  EXPECT_LT(problem.errors_of(truth, 3).phi, tolerance);
  EXPECT_LT(problem.errors_of(truth, 3).maps, tolerance);
  EXPECT_LT(problem.truth_error(), tolerance);
}

TEST(BenchProblem, ErrorIsTheWorstPatternsRelativeDistance) {
  const Problem problem(small(), "auto");
  auto phi = converged_fluence(problem.setup(), problem.medium(), problem.irradiance(), 3);
  const std::size_t cells = problem.setup().shape.cells();
  for (std::size_t i = cells; i < 2 * cells; ++i) phi[i] *= 1.001;
  for (std::size_t i = 2 * cells; i < 3 * cells; ++i) phi[i] *= 1.0001;
  EXPECT_NEAR(problem.errors_of(phi, 3).phi, 1e-3, 1e-9);
  EXPECT_NEAR(problem.errors_of(phi, 3).maps, 1e-3, 1e-9);
  EXPECT_NEAR(problem.errors_of(phi, 1).phi, 0.0, 1e-9) << "only patterns given are compared";
}

TEST(BenchProblem, AssembledMatrixIsTheSolversOperator) {
  const Problem problem(small(1), "auto");
  const GridShape& s = problem.setup().shape;
  const auto solver = forward::make_reference_solver(problem.setup());
  solver->set_medium(problem.medium().kappa.values(), problem.medium().mu.values());
  std::mt19937 generator(7);
  std::vector<double> x(s.cells()), expected(s.cells());
  for (double& value : x) value = static_cast<double>(generator()) / 4294967296.0;
  const auto field = solver->make_field(1);
  const auto product = solver->make_field(1);
  solver->fill(*field, x);
  solver->apply(*field, *product);
  solver->read(*product, expected);

  const AssembledMatrix matrix = assemble(problem.setup(), problem.constants(), problem.medium());
  std::vector<double> y(s.cells());
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = matrix.diagonal[i] * x[i];
  const std::array<std::size_t, 3> stride{
      1, static_cast<std::size_t>(s.nx),
      static_cast<std::size_t>(s.nx) * static_cast<std::size_t>(s.ny)};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t i = 0; i + stride[a] < y.size(); ++i) {
      y[i] -= matrix.link[a][i] * x[i + stride[a]];
      y[i + stride[a]] -= matrix.link[a][i] * x[i];
    }
  }
  constexpr double rounding = 1e-13;  // seven terms of a few hundred eps
  EXPECT_LT(worst_difference(y, expected, 1), rounding);
}

Sample at(double error, double seconds) {
  Sample sample;
  sample.phi_error = error;
  sample.seconds_per_rhs = seconds;
  return sample;
}

TEST(SecondsAtError, FollowsAPowerLawExactly) {
  // seconds = error^(−1/4)
  const std::vector<Sample> samples{at(1e-2, std::pow(1e-2, -0.25)), at(1e-4, 10.0),
                                    at(1e-8, 100.0)};
  EXPECT_NEAR(seconds_at_error(samples, 1e-6).value(), std::pow(1e-6, -0.25), 1e-9);
  EXPECT_NEAR(seconds_at_error(samples, 1e-3).value(), std::pow(1e-3, -0.25), 1e-9);
}

TEST(SecondsAtError, IsTheCheapestWhereAllAreBetterAndNothingWhereNoneIs) {
  const std::vector<Sample> samples{at(1e-3, 1.0), at(1e-5, 2.0)};
  EXPECT_EQ(seconds_at_error(samples, 1e-1), 1.0);
  EXPECT_EQ(seconds_at_error(samples, 1e-6), std::nullopt);
  EXPECT_EQ(cheapest_at_error(samples, 1e-4), &samples[1]);
  EXPECT_EQ(cheapest_at_error(samples, 1e-6), nullptr);
}

TEST(MeasureGridSolver, AsksForTheWorkItReports) {
  const Problem problem(small(), "auto");
  const auto samples = measure_grid_solver(problem, "auto", forward::Precision::double_precision, 3,
                                           {1e-3, 1e-8}, 2);
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_GT(samples[1].iterations, samples[0].iterations);
  EXPECT_LT(samples[1].error().value(), 1e-6);
  EXPECT_GT(samples[0].error().value(), samples[1].error().value());
  EXPECT_NEAR(samples[0].seconds_per_rhs,
              samples[0].solve_seconds_per_rhs + samples[0].set_up_seconds / 3.0, 1e-12);
}

}  // namespace
}  // namespace kappamu::studies
