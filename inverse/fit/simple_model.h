// Whether a model of few unknowns ends the fit before any voxel has one of its own.
#pragma once

#include <optional>

#include "inverse/block_model/model_choice.h"
#include "inverse/fit/fit_run.h"

namespace kappamu::inverse {

/// Tries the models of few unknowns from the homogeneous start; the one that was asked for or that
/// the data do not reject. The report says why; what the data rejected is in FitState::simpler.
std::optional<SimpleFit> choose_simple_model(FitRun& run);

/// `simple` is the fit's volume, on the finest grid, with its words.
void conclude_simple(FitRun& run, SimpleFit simple);

}  // namespace kappamu::inverse
