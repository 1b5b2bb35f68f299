// What L-BFGS learned at one weight, in one set of coordinates, must hold at the next.
#include "inverse/optimise/fit_function.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "inverse/optimise/lateral_hessian.h"
#include "inverse/problem/problem.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

struct Kind {
  const char* name;
  RegulariserKind regulariser;
  AbsorptionScale scale{};
  double bend = 1e-6;
};

class CarriedPair : public ::testing::TestWithParam<Kind> {};

/// A step and the change of the gradient it brings, of a function with another weight and another
/// metric, against the same step measured here. H1's Hessian is constant, so that nothing but the
/// solver's tolerance remains; Huber-TV's is that of the Gaussian which stands for it. A scale of μ
/// bends by as much as the step is long.
TEST_P(CarriedPair, IsThePairOfTheNewFunction) {
  test_cases::Block block;
  block.grid = {8, 7, 5, 0.5};
  const SurfaceMeasurements m =
      cases::measure(block, cases::smooth_medium(block.grid.refined(2)), 2);
  Backend exact;
  exact.precision = forward::Precision::double_precision;
  exact.solve.tolerance = 1e-11;
  Objective objective(make_problem(m, 0, forward::Convention::physical, {0.001, 5e-5}), exact);
  const CoefficientPair here = cases::rough_medium(block.grid, 0.1, 3);
  objective.value(here);
  const LateralBlocks blocks = lateral_blocks(random_rows(objective, 2, 1), objective.space());
  const MediumSpace space{{8, 7, 5, 0.5}, 2, 2.5};
  const Basis first(space, {Coordinates::informed, 2.5, 300.0}, blocks);
  const Basis second(space, {Coordinates::smooth, 2.5, 50.0}, {});
  const Regulariser regulariser{GetParam().regulariser, 100.0, 1.0};
  const Anchor anchor{std::log(0.15), std::log(0.05), 25.0};
  FitFunction before(objective, first, anchor, 300.0, regulariser, here, GetParam().scale);
  FitFunction after(objective, second, anchor, 50.0, regulariser, here, GetParam().scale);

  const auto gradient_at = [](FitFunction& function, const Vector& z) {
    function.value(z);
    return function.gradient();
  };
  CoefficientPair there = here;
  const CoefficientPair way = cases::random_direction(block.grid, 5);
  constexpr double length = 1e-2;
  for (std::size_t i = 0; i < block.grid.cells(); ++i) {
    there.log_kappa[i] += length * way.log_kappa[i];
    there.log_mu[i] += length * way.log_mu[i];
  }
  const auto pair_of = [&](FitFunction& function) {
    Vector step = function.coordinates(there);
    Vector change = gradient_at(function, step);
    const Vector z = function.coordinates(here);
    const Vector g = gradient_at(function, z);
    for (std::size_t i = 0; i < z.size(); ++i) {
      step[i] -= z[i];
      change[i] -= g[i];
    }
    return std::pair{step, change};
  };
  auto [step, change] = pair_of(before);
  const auto [expected_step, expected_change] = pair_of(after);
  const Vector untouched = change;
  after.adopt(before, step, change);

  const auto distance = [](const Vector& a, const Vector& b) {
    double off = 0.0;
    double all = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      off += std::pow(a[i] - b[i], 2);
      all += std::pow(b[i], 2);
    }
    return std::sqrt(off / all);
  };
  EXPECT_LT(distance(step, expected_step), 1e-9);
  EXPECT_LT(distance(change, expected_change), GetParam().bend);
  EXPECT_GT(distance(untouched, expected_change), 0.1) << "nothing was asked of adopt()";
}
INSTANTIATE_TEST_SUITE_P(Of, CarriedPair,
                         ::testing::Values(Kind{"H1", RegulariserKind::h1},
                                           Kind{"H1InTheFitsOwnScale", RegulariserKind::h1,
                                                AbsorptionScale(0.02), 0.02},
                                           Kind{"HuberTvBelowItsEdge", RegulariserKind::huber_tv}),
                         [](const auto& kind) { return std::string(kind.param.name); });

/// docs/theory.md, section 4: where an overstated noise lets the path end.
TEST(FitFunction, TellsChi2UnderTheNextWeightFromTheMinimumUnderThisOne) {
  test_cases::Block block;
  block.grid = {20, 18, 6, 0.5};
  const SurfaceMeasurements m =
      cases::measure(block, test_cases::make_truth(block.grid.refined(2), {}));
  FitOptions options;
  options.path.correct_grid = false;
  options.path.final_tolerance = 1e-5;
  const auto fit_at = [&](double weight) {
    options.path.weight = weight;
    return cases::fit(m, options);
  };
  const ChannelFit fit = fit_at(900.0);

  Objective objective(make_problem(m, 0, options.data.convention, options.data.model_error), {});
  const CoefficientPair fields = to_fields(fit.medium);
  objective.value(fields);
  const LateralBlocks blocks = lateral_blocks(random_rows(objective, 2, 1), objective.space());
  const double depth = 3.0;
  const auto basis = [&](double weight) {
    return Basis({block.grid, 2, depth}, {Coordinates::informed, depth, weight}, blocks);
  };
  const Anchor anchor{std::log(fit.report.homogeneous_kappa), std::log(fit.report.homogeneous_mu),
                      options.regulariser.anchor_length * depth};
  const Basis here = basis(900.0);
  const FitFunction function(objective, here, anchor, 900.0, {}, fields);
  for (const double weight : {270.0, 3000.0}) {
    const double gain = function.chi2_gain(fields, basis(weight), weight);
    const double found = (fit.report.chi2_per_value - fit_at(weight).report.chi2_per_value) *
                         static_cast<double>(objective.problem().used());
    EXPECT_NEAR(gain / found, 1.0, 0.3) << weight << ": " << gain << ", found " << found;
  }
}

}  // namespace
}  // namespace kappamu::inverse
