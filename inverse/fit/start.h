// Where a fit starts: the best homogeneous block, and the equation that light obeys in it.
#pragma once

#include "inverse/block_model/homogeneous.h"
#include "inverse/fit/fit_run.h"

namespace kappamu::inverse {

/// By diffusion, then by the physics asked for or found to be needed, which it sets; on the
/// coarsest grid, which is open. Throws InputError for data that no fit can start from.
HomogeneousFit find_start(FitRun& run);

}  // namespace kappamu::inverse
