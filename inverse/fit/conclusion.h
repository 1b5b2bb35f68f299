// What comes of a fit: how it ended, in a sentence; whether its data are consistent; how far it can
// be trusted.
#pragma once

#include "inverse/fit/fit_run.h"
#include "inverse/fit/minimise.h"

namespace kappamu::inverse {

/// How and why the path ended, into the report.
void conclude(FitRun& run, const Stage& stage);

/// Whether the images are shifted or too bright, by the volume that was fitted, at which the
/// objective is. One that does not explain the data may show a shift but clears them of none: its
/// edges stand for it. [W]'s regulariser says nothing of what volumes are likely.
void check_data(FitRun& run);

/// What the data say of each voxel, and what deviations are made of (fit_uncertainty.h), as far as
/// they are asked for.
void find_deviations(FitRun& run, ChannelFit& fit);

}  // namespace kappamu::inverse
