// The end of a fit: its reason in a sentence, the checks of its data, its deviations.
#pragma once

#include "inverse/fit/fit_run.h"
#include "inverse/fit/minimise.h"

namespace kappamu::inverse {

/// How a path ended: χ² per value, SharedErrors::excess, its last weight, and why there.
struct EndedPath {
  double chi2 = 0.0;
  double excess = 0.0;
  double weight = 0.0;
  PathEnd end = PathEnd::unknown;
  bool ran_out = false;  ///< of steps, at that weight
};
/// Status of the fit, and its reason in a sentence.
void conclude_path(const PathOptions& path, const EndedPath& ended, FitReport& report);

/// How and why the path ended, into the report.
void conclude(FitRun& run, const Stage& stage);

/// Whether the images are shifted or too bright, by the fitted volume, at which the objective is. A
/// volume that does not explain the data may show a shift but does not exclude one, because its
/// edges may explain it. Skipped with [W]'s regulariser, which is no prior.
void check_data(FitRun& run);

/// Sensitivities and the parts of the deviations (fit_uncertainty.h), if asked for.
void find_deviations(FitRun& run, ChannelFit& fit);

}  // namespace kappamu::inverse
