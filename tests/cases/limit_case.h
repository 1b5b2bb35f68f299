// One solve at the edge of what the grid solver can do, and how far its answer is from the solution
// of its equations.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "forward/grid/grid_solver.h"
#include "tests/cases/media.h"

namespace kappamu::test_cases {

struct LimitCase {
  forward::GridSetup setup;
  MediumSpec medium;
  int patterns = 1;  ///< patch_light of the lit face
  forward::SolveOptions options{};
  forward::Precision precision = forward::Precision::single_precision;
  std::string device = "auto";
  bool with_error = true;  ///< solve for the truth too; minutes above 10⁶ voxels
};

struct LimitOutcome {
  forward::Termination termination = forward::Termination::failed;
  int iterations = 0;
  double residual = 0.0;             ///< of the worst pattern
  std::optional<double> true_error;  ///< ‖φ − φ*‖/‖φ*‖ of the worst pattern
  std::optional<double> dark_error;  ///< the same of the exitance map opposite the lit face
  double transmitted = 0.0;          ///< exiting there over entering, all patterns
  double reflected = 0.0;            ///< exiting at the lit face over entering
  double imbalance = 0.0;  ///< |entering − leaving − absorbed|/entering, worst pattern
  std::string message;     ///< the solver's sentence
  std::vector<std::string> warnings;  ///< what the program says about this medium and device
};

LimitOutcome run_limit(const LimitCase& limit);

/// "converged", "ran out", "failed"
std::string to_string(forward::Termination termination);

/// φ* [pattern][z][y][x]: the serial reference's solution, refined with residuals in long double
/// until the correction is below 1e-13 of it, so that its own error is that of κ's and b's
/// rounding. Throws InternalError when refinement does not get there.
std::vector<double> converged_fluence(const forward::GridSetup& setup, const Medium& medium,
                                      const std::vector<double>& irradiance, int patterns);

/// ‖a − b‖/‖b‖ of the worst of `patterns` equal parts. A part where b is zero counts ‖a‖.
double worst_difference(const std::vector<double>& a, const std::vector<double>& b, int patterns);

}  // namespace kappamu::test_cases
