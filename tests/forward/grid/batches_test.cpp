// Starts and batches: what a solve does with the guess it is given, and that a pattern's answer
// does not depend on what is solved before it, after it or beside it.
#include <gtest/gtest.h>

#include <limits>

#include "device/context.h"
#include "forward/grid/opencl/opencl_solver.h"
#include "tests/forward/grid/backends.h"
#include "tests/forward/grid/test_tools.h"

namespace kappamu::forward {
namespace {

using testing::Coefficients;
using testing::Values;

constexpr GridShape block{21, 18, 9, 0.3};
constexpr std::size_t lit_cells = std::size_t{21} * 18;

Values light_of(int patterns, unsigned seed) {
  return testing::random_values(lit_cells * static_cast<std::size_t>(patterns), 0, 1, seed);
}

/// ‖b − A φ‖/‖b‖ over the whole batch, by apply().
double residual_of(const GridSolver& solver, const BatchField& b, const BatchField& phi) {
  const auto image = solver.make_field(phi.patterns());
  solver.apply(phi, *image);
  return testing::relative_difference(testing::read(solver, *image), testing::read(solver, b));
}

class GridStarts : public testing::OnBackend {};

/// As in a fit, where each step's medium is near the last one's.
TEST_P(GridStarts, TheSolutionForANearbyMediumSavesIterations) {
  constexpr double tolerance = 1e-6;
  constexpr int patterns = 3;
  const auto s = solver({.shape = block});
  const Coefficients medium = testing::random_medium(block, 10, 31);
  Coefficients nearby = medium;
  const Values change = testing::random_values(block.cells(), -0.01, 0.01, 33);
  for (std::size_t i = 0; i < change.size(); ++i) {
    nearby.kappa[i] *= 1 + change[i];
    nearby.mu[i] *= 1 - change[i];
  }
  const Values light = light_of(patterns, 34);
  s->set_medium(medium.kappa, medium.mu);
  auto warm = testing::solve_light(*s, light, patterns, {tolerance, 100});
  s->set_medium(nearby.kappa, nearby.mu);
  const auto cold = testing::solve_light(*s, light, patterns, {tolerance, 100});
  const auto b = s->make_field(patterns);
  s->light_source(light, *b);
  const SolveReport report = s->solve(*b, *warm.phi, {tolerance, 100});
  ASSERT_EQ(report.termination, Termination::converged) << report.message;
  // A guess good to 1 % has two of the six decades behind it.
  EXPECT_GT(report.iterations, 0);
  EXPECT_LE(report.iterations, cold.report.iterations - 1);
  // apply() of a rounded φ adds storage rounding times the conductances to the residual.
  EXPECT_LE(residual_of(*s, *b, *warm.phi), tolerance + 10 * rounding());
}

TEST_P(GridStarts, ASolutionIsLeftAsItIs) {
  const auto s = solver({.shape = block});
  const Coefficients medium = testing::random_medium(block, 10, 35);
  s->set_medium(medium.kappa, medium.mu);
  const Values light = light_of(2, 36);
  auto solution = testing::solve_light(*s, light, 2, {1e-7, 100});
  const Values before = testing::read(*s, *solution.phi);
  const auto b = s->make_field(2);
  s->light_source(light, *b);
  const SolveReport report = s->solve(*b, *solution.phi, {1e-6, 100});
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(report.termination, Termination::converged);
  EXPECT_LE(testing::relative_difference(testing::read(*s, *solution.phi), before), rounding());
}

/// Zeros are known to be zeros, whoever wrote them, and nothing else is.
TEST_P(GridStarts, AFieldStartsFromWhatItWasFilledWith) {
  const auto s = solver({.shape = block});
  const Coefficients medium = testing::random_medium(block, 10, 38);
  s->set_medium(medium.kappa, medium.mu);
  const Values light = light_of(2, 39);
  const Values fresh = testing::read(*s, *testing::solve_light(*s, light, 2, {1e-7, 100}).phi);
  const auto b = s->make_field(2), phi = s->make_field(2);
  s->light_source(light, *b);
  s->fill(*phi, fresh);
  EXPECT_EQ(s->solve(*b, *phi, {1e-5, 100}).iterations, 0);
  s->fill(*phi, Values(fresh.size(), 0.0));
  s->solve(*b, *phi, {1e-7, 100});
  EXPECT_EQ(testing::read(*s, *phi), fresh);
}

/// Memory is used again.
TEST_P(GridStarts, ANewFieldIsZeroWhateverItsMemoryHeld) {
  const auto s = solver({.shape = block});
  const Coefficients medium = testing::random_medium(block, 10, 40);
  s->set_medium(medium.kappa, medium.mu);
  const Values light = light_of(2, 41), ones(2 * block.cells(), 1.0);
  const Values fresh = testing::read(*s, *testing::solve_light(*s, light, 2, {1e-7, 100}).phi);
  const auto used = [&] {
    s->fill(*s->make_field(2), ones);
    return s->make_field(2);
  };
  EXPECT_EQ(testing::norm(testing::read(*s, *used())), 0.0);
  const auto b = used(), phi = used();
  s->apply(*phi, *b);
  EXPECT_EQ(testing::norm(testing::read(*s, *b)), 0.0);
  EXPECT_EQ(testing::norm(s->weighted_sums(*used(), Values(block.cells(), 1.0))), 0.0);
  s->light_source(light, *b);
  s->solve(*b, *phi, {1e-7, 100});
  EXPECT_EQ(testing::read(*s, *phi), fresh);
}

TEST_P(GridStarts, DarknessNeedsNoIterations) {
  const auto s = solver({.shape = block});
  const Coefficients medium = testing::random_medium(block, 100, 37);
  s->set_medium(medium.kappa, medium.mu);
  const auto solution = testing::solve_light(*s, Values(lit_cells * 2, 0.0), 2, {1e-8, 100});
  EXPECT_EQ(solution.report.iterations, 0);
  EXPECT_EQ(solution.report.termination, Termination::converged);
  EXPECT_EQ(testing::norm(testing::read(*s, *solution.phi)), 0.0);
}

/// A dark pattern beside lit ones: its scalars are 0/0 in every step.
TEST_P(GridStarts, ADarkPatternStaysDarkBesideLitOnes) {
  constexpr int patterns = 3;
  const auto s = solver({.shape = block});
  const Coefficients medium = testing::random_medium(block, 100, 38);
  s->set_medium(medium.kappa, medium.mu);
  Values light = light_of(patterns, 39);
  std::fill_n(light.begin() + lit_cells, lit_cells, 0.0);
  const auto solution = testing::solve_light(*s, light, patterns, {1e-6, 100});
  EXPECT_EQ(solution.report.termination, Termination::converged) << solution.report.message;
  const Values phi = testing::read(*s, *solution.phi);
  const auto cells = static_cast<std::ptrdiff_t>(block.cells());
  EXPECT_EQ(testing::norm(Values(phi.begin() + cells, phi.begin() + 2 * cells)), 0.0);
  EXPECT_GT(testing::norm(Values(phi.begin(), phi.begin() + cells)), 0.0);
}

INSTANTIATE_TEST_SUITE_P(, GridStarts,
                         ::testing::Values(testing::reference_backend, testing::opencl_single,
                                           testing::opencl_double),
                         testing::backend_name);

class GridBatches : public testing::OnBackend {};

/// Work space is kept between solves; nothing of one may reach the next.
TEST_P(GridBatches, AnotherSolveInBetweenChangesNoBit) {
  const Coefficients medium = testing::random_medium(block, 100, 41);
  const Coefficients other = testing::random_medium(block, 1000, 42);
  const auto s = solver({.shape = block});
  const SolveOptions options{1e-6, 100};
  const auto solved = [&](const Coefficients& c, int patterns, unsigned seed) {
    s->set_medium(c.kappa, c.mu);
    return testing::read(
        *s, *testing::solve_light(*s, light_of(patterns, seed), patterns, options).phi);
  };
  const Values once = solved(medium, 16, 43);
  const Values again = solved(medium, 16, 43);
  EXPECT_EQ(once, again);
  // Fewer patterns, stopped early, and a right-hand side that leaves not-a-number behind.
  solved(other, 5, 44);
  Values bad(block.cells(), 1.0);
  bad[7] = std::numeric_limits<double>::quiet_NaN();
  testing::solve_rhs(*s, bad, 1, options);
  EXPECT_EQ(once, solved(medium, 16, 43));
}

/// Patterns beyond the sixteenth are a block of their own.
TEST_P(GridBatches, PatternsOfTheNextBlockChangeNoBit) {
  const Coefficients medium = testing::random_medium(block, 100, 45);
  const auto s = solver({.shape = block});
  s->set_medium(medium.kappa, medium.mu);
  const Values light = light_of(22, 46);
  const auto all = testing::solve_light(*s, light, 22, {1e-6, 100});
  const auto sixteen = testing::solve_light(
      *s, Values(light.begin(), light.begin() + static_cast<std::ptrdiff_t>(16 * lit_cells)), 16,
      {1e-6, 100});
  Values first = testing::read(*s, *all.phi);
  first.resize(16 * block.cells());
  EXPECT_EQ(first, testing::read(*s, *sixteen.phi));
}

/// A device too small for the whole batch solves it in parts: the same fluence, exitance and
/// products for a gradient.
TEST_P(GridBatches, FewerPatternsAtOnceGiveTheSameAnswers) {
  constexpr int patterns = 11;
  const double tolerance = single() ? 1e-7 : 1e-12;
  const double allowed = single() ? 3e-6 : 1e-10;  // tolerance times the condition of this block
  const Coefficients medium = testing::random_medium(block, 100, 47);
  const Values light = light_of(patterns, 48);
  device::Context& context = device::Context::chosen(GetParam().device);
  struct Answers {
    Values phi, exitance, products, columns;
  };
  const auto answers = [&](int most_lanes) {
    const auto s = make_opencl_solver(
        {.shape = block}, context,
        {.precision = GetParam().precision, .trust = Trust::blind, .most_lanes = most_lanes});
    s->set_medium(medium.kappa, medium.mu);
    const auto solution = testing::solve_light(*s, light, patterns, {tolerance, 100});
    EXPECT_EQ(solution.report.termination, Termination::converged) << solution.report.message;
    EXPECT_EQ(solution.report.residual.size(), std::size_t{patterns});
    return Answers{testing::read(*s, *solution.phi),
                   testing::exitance(*s, *solution.phi, Face::z_plus, Values{}),
                   s->pair_products(*solution.phi, *solution.phi).face_x,
                   s->column_products(*solution.phi, light)};
  };
  const Answers whole = answers(full_lanes);
  for (const int lanes : {8, 4, 1}) {
    SCOPED_TRACE(lanes);
    const Answers parts = answers(lanes);
    EXPECT_LE(testing::relative_difference(parts.phi, whole.phi), allowed);
    EXPECT_LE(testing::relative_difference(parts.exitance, whole.exitance), allowed);
    EXPECT_LE(testing::relative_difference(parts.products, whole.products), allowed);
    EXPECT_LE(testing::relative_difference(parts.columns, whole.columns), allowed);
  }
}

INSTANTIATE_TEST_SUITE_P(, GridBatches,
                         ::testing::Values(testing::opencl_single, testing::opencl_double),
                         testing::backend_name);

}  // namespace
}  // namespace kappamu::forward
