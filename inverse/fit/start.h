// The start of a fit: best homogeneous block, choice of physics, and models of few unknowns, one of
// which may end the fit.
#pragma once

#include <optional>

#include "inverse/block_model/homogeneous.h"
#include "inverse/block_model/model_choice.h"
#include "inverse/fit/fit_run.h"

namespace kappamu::inverse {

/// By diffusion first, then by the physics asked for or chosen, which it sets. The coarsest grid is
/// open. Throws InputError for data that no fit can start from.
HomogeneousFit find_start(FitRun& run);

/// Tries the models of few unknowns from the homogeneous start; returns the one that was asked for
/// or that the data do not reject, with the reason in the report. Rejected ones are in
/// FitState::simpler.
std::optional<SimpleFit> choose_simple_model(FitRun& run);

/// `simple` is the fit's volume, on the finest grid, with its words.
void conclude_simple(FitRun& run, SimpleFit simple);

}  // namespace kappamu::inverse
