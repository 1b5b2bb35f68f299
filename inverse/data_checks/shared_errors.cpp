#include "inverse/data_checks/shared_errors.h"

#include <cmath>

#include "core/shown_text.h"

namespace kappamu::inverse {

namespace {

/// χ² per value that chance exceeds as rarely as a normal number exceeds three standard deviations
/// (Wilson and Hilferty 1931).
double by_chance(double values) {
  const double variance = 2.0 / (9.0 * values);
  return std::pow(1.0 - variance + 3.0 * std::sqrt(variance), 3);
}

}  // namespace

SharedErrors shared_errors(const Problem& problem, const DataTermOptions& options,
                           const std::vector<double>& prediction) {
  SharedErrors found;
  if (!shares_errors(problem, options)) return found;
  std::vector<double> residuals(prediction.size());
  double predicted = 0.0;
  double measured = 0.0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    if (problem.weight[i] == 0.0) continue;
    residuals[i] = std::sqrt(problem.weight[i]) * (prediction[i] - problem.data[i]);
    predicted += prediction[i];
    measured += problem.data[i];
  }
  const SmoothError& stated = problem.smooth_error;
  found.mean = predicted / measured - 1.0;
  found.stated = stated.common > 0.0 ? stated.common : stated.own / std::sqrt(problem.patterns);
  for (const OctaveMisfit& octave : problem.precision->octaves(residuals)) {
    const double excess = octave.chi2 / octave.values / by_chance(octave.values);
    if (excess <= found.excess) continue;
    found.excess = excess;
    found.octave = octave;
  }
  return found;
}

double SharedErrors::mean_off() const {
  return stated > 0.0 ? std::abs(mean) / stated : 0.0;
}

std::string mean_in_words(const SharedErrors& errors) {
  return formatted("predicted %.2g %% too %s in the mean", 100.0 * std::abs(errors.mean),
                   errors.mean < 0.0 ? "dark" : "bright");
}

std::string octave_in_words(const SharedErrors& errors) {
  const OctaveMisfit& octave = errors.octave;
  const char* whose = octave.of_mean ? "all patterns" : "single patterns";
  const double times = std::sqrt(octave.chi2 / octave.values);
  if (octave.longest == 0.0) {
    return formatted("the mean light of %s is %.2g times its stated error off", whose, times);
  }
  return formatted("waves of %.3g to %.3g voxels of %s are %.2g times their stated errors off",
                   0.5 * octave.longest, octave.longest, whose, times);
}

}  // namespace kappamu::inverse
