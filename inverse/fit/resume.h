// A fit that goes on from a checkpoint.
#pragma once

#include "inverse/fit/fit_run.h"
#include "inverse/fit/minimise.h"

namespace kappamu::inverse {

/// From the newest checkpoint that can be used: grid, r and `stage` are what they were, to the same
/// bits and counts; false where there is none. What could not be used is told of.
bool resume(FitRun& run, Stage& stage);

}  // namespace kappamu::inverse
