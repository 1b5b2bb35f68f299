// Problems and one-line solves for the tests of the baselines.
#pragma once

#include <string>

#include "core/error.h"
#include "device/device_info.h"
#include "studies/baseline/baseline_model.h"
#include "tests/forward/grid/test_tools.h"

namespace kappamu::forward::testing {

namespace baseline = studies::baseline;

/// κ = 0.3 mm, μ = 0.01 / mm, even light of 1 on z-.
inline ForwardProblem uniform_problem(const GridShape& shape) {
  ForwardProblem problem;
  problem.setup.shape = shape;
  problem.medium = {Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)};
  problem.irradiance.assign(face_shape(shape, problem.setup.lit_face).cells(), 1.0);
  return problem;
}

/// κ of the given contrast and light from fixed seeds.
inline ForwardProblem random_problem(const GridShape& shape, Face lit, double contrast,
                                     int patterns) {
  ForwardProblem problem = uniform_problem(shape);
  problem.setup.lit_face = lit;
  Coefficients c = random_medium(shape, contrast, 11);
  problem.medium = {Volume<double>(shape, std::move(c.kappa)),
                    Volume<double>(shape, std::move(c.mu))};
  problem.patterns = patterns;
  problem.irradiance = random_values(
      face_shape(shape, lit).cells() * static_cast<std::size_t>(patterns), 0.0, 1.0, 5);
  return problem;
}

inline ForwardOptions options_for(double tolerance, Precision precision) {
  ForwardOptions options;
  options.precision = precision;
  options.solve = {tolerance, 1'000'000};
  return options;
}

inline ForwardResult solve(const std::string& method, const ForwardProblem& problem,
                           double tolerance, Precision precision = Precision::double_precision) {
  Progress progress;
  return baseline::make_model(method)->solve(problem, options_for(tolerance, precision), progress);
}

/// |entering − exiting − unscattered − absorbed| / entering of the first pattern.
inline double imbalance(const ForwardResult& result) {
  const PowerBalance& balance = result.balance.front();
  double out = balance.unscattered + balance.absorbed;
  for (const double exiting : balance.exiting) out += exiting;
  return std::abs(balance.entering - out) / balance.entering;
}

}  // namespace kappamu::forward::testing
