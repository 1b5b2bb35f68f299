// Whether a fit's residuals agree with the stated errors that pixels share (smooth_error.h). χ² of
// all values is no test of it: the mean of the light and its longest waves are a few values among
// thousands, so that χ² hides errors of fifty of their standard deviations.
#pragma once

#include <string>
#include <vector>

#include "inverse/problem/data_term.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

struct SharedErrors {
  /// χ² of the worst octave over its bound, three standard deviations of chance; at most 1 if the
  /// stated errors hold. 0: errors are independent.
  double excess = 0.0;
  OctaveMisfit octave;  ///< that one
  /// Predicted over measured sum of all light used, less 1.
  double mean = 0.0;
  double stated = 0.0;  ///< standard deviation of that, by the statement; 0: none

  /// Times what is stated.
  double mean_off() const;
};

/// `prediction` [M][v][u] as problem.data. All zero if no shared errors are stated.
SharedErrors shared_errors(const Problem& problem, const DataTermOptions& options,
                           const std::vector<double>& prediction);

/// Clauses: "predicted 0.2 % too dark in the mean", and how far the worst octave is off.
std::string mean_in_words(const SharedErrors& errors);
std::string octave_in_words(const SharedErrors& errors);

}  // namespace kappamu::inverse
