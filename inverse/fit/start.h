// Where a fit starts: the best homogeneous block, the equation that light obeys in it, and whether
// a model of few unknowns ends the fit before any voxel has one of its own.
#pragma once

#include <optional>

#include "inverse/block_model/homogeneous.h"
#include "inverse/block_model/model_choice.h"
#include "inverse/fit/fit_run.h"

namespace kappamu::inverse {

/// By diffusion, then by the physics asked for or found to be needed, which it sets; on the
/// coarsest grid, which is open. Throws InputError for data that no fit can start from.
HomogeneousFit find_start(FitRun& run);

/// Tries the models of few unknowns from the homogeneous start; returns the one that was asked for
/// or that the data do not reject, with the reason in the report. Rejected ones are in
/// FitState::simpler.
std::optional<SimpleFit> choose_simple_model(FitRun& run);

/// `simple` is the fit's volume, on the finest grid, with its words.
void conclude_simple(FitRun& run, SimpleFit simple);

}  // namespace kappamu::inverse
