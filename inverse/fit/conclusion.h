// The end of a fit: its reason in a sentence, the checks of its data, its deviations.
#pragma once

#include "inverse/fit/fit_run.h"
#include "inverse/fit/minimise.h"

namespace kappamu::inverse {

/// How and why the path ended, into the report.
void conclude(FitRun& run, const Stage& stage);

/// Whether the images are shifted or too bright, by the fitted volume, at which the objective is. A
/// volume that does not explain the data may show a shift but does not exclude one, because its
/// edges may explain it. Skipped with [W]'s regulariser, which is no prior.
void check_data(FitRun& run);

/// Sensitivities and the parts of the deviations (fit_uncertainty.h), if asked for.
void find_deviations(FitRun& run, ChannelFit& fit);

}  // namespace kappamu::inverse
