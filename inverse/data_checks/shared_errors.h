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
  /// Of the octave that is furthest off: χ² over what chance lets it be, at three standard
  /// deviations of chance; at most 1 where the statement holds. 0: errors are independent.
  double excess = 0.0;
  OctaveMisfit octave;  ///< that one
  /// Of all light used, predicted over measured, less 1.
  double mean = 0.0;
  double stated = 0.0;  ///< standard deviation of that, by the statement; 0: none

  /// Times what is stated.
  double mean_off() const;
};

/// Of `prediction` [M][v][u] as problem.data; of zeros where nothing is stated.
SharedErrors shared_errors(const Problem& problem, const DataTermOptions& options,
                           const std::vector<double>& prediction);

/// Clauses: "predicted 0.2 % too dark in the mean", and how far the worst octave is off.
std::string mean_in_words(const SharedErrors& errors);
std::string octave_in_words(const SharedErrors& errors);

}  // namespace kappamu::inverse
