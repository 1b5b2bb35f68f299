// Time and true error of one method at one tolerance, for ours and for the papers' methods alike.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "studies/forward/problem.h"

namespace kappamu::studies {

struct Sample {
  std::string method;     ///< name in forward_methods(), or of a peer
  std::string precision;  ///< "single", "double"
  std::string setting;    ///< of a peer
  double tolerance = 0.0;
  int patterns = 0;    ///< solved in this measurement
  int iterations = 0;  ///< of the slowest pattern
  bool converged = false;
  double set_up_seconds = 0.0;         ///< once for all patterns
  double solve_seconds_per_rhs = 0.0;  ///< median over repetitions
  double seconds_per_rhs = 0.0;        ///< solve + set-up shared by the problem's patterns
  std::optional<double> map_error;     ///< of the exitance maps; none: not compared
  std::optional<double> phi_error;     ///< where the method shows φ
  std::optional<double> error() const { return phi_error ? phi_error : map_error; }
};

/// Our solver through GridSolver; `device` "reference" is the serial one. Set-up is set_medium(),
/// everything that is redone when κ and μ change. Medians over `repetitions`. `fluence` receives
/// that of the last solve, [pattern][z][y][x].
std::vector<Sample> measure_grid_solver(const Problem& problem, const std::string& device,
                                        forward::Precision precision, int patterns,
                                        const std::vector<double>& tolerances, int repetitions,
                                        std::vector<double>* fluence = nullptr);

/// A method that baseline::make_model knows, as a user would call it, once per tolerance, largest
/// first, until a solve exceeds `budget_seconds`; the last one's number of sweeps is cut to what
/// fits into it.
std::vector<Sample> measure_model(const Problem& problem, const std::string& method,
                                  const std::string& device, const std::vector<double>& tolerances,
                                  double budget_seconds);

/// Time at which a method reaches `error`, interpolated between its two neighbouring samples on
/// logarithmic axes; the cheapest sample's where all are better; nothing where none is.
std::optional<double> seconds_at_error(const std::vector<Sample>& samples, double error);

/// The cheapest sample with at most `error`; null where there is none.
const Sample* cheapest_at_error(const std::vector<Sample>& samples, double error);

}  // namespace kappamu::studies
