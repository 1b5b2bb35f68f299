// The minimum at one weight: its metric, the optimiser's steps, and what the metric lets expect of
// the next weight.
#pragma once

#include <memory>
#include <optional>

#include "inverse/fit/fit_run.h"
#include "inverse/fit/path_rules.h"
#include "inverse/on_device/steps.h"
#include "inverse/optimise/basis.h"
#include "inverse/optimise/fit_function.h"

namespace kappamu::inverse {

/// One weight on the open grid; the next one of that grid begins from this, so that what was
/// learned of the Hessian goes on.
struct Stage : StageState {
  std::unique_ptr<Basis> basis;
  std::unique_ptr<FitFunction> function;
  std::unique_ptr<Steps> stepping;  ///< from the function's first step on
  bool ran_out = false;             ///< of steps, before the minimum
};

/// The metric and the function of the run's weight, from the run's fields.
void begin_weight(FitRun& run, Stage& stage);
/// The same weight, from where it has come to, with r renewed.
void repeat_weight(FitRun& run, Stage& stage);

/// The run's weight as it was when `saved`, by the r it then had, which the objective has. Throws
/// InternalError where no metric can be made of it.
void restore_weight(FitRun& run, Stage& stage, StageState saved);
/// From the newest checkpoint that can be used (resume.cpp): grid, r and `stage` are what they
/// were, to the same bits and counts; false where there is none. What could not be used is
/// reported.
bool resume(FitRun& run, Stage& stage);

/// To the minimum, r renewed there; once more where that takes it back. At the last minimum r is
/// not renewed where it holds. The run's fields are then the volume found.
Minimum settle(FitRun& run, Stage& stage);

/// Predicted by the metric at the minimum with `chi2` per value. Empty without a metric and on
/// coarser grids, which keep their weight.
std::optional<Outlook> outlook(const FitRun& run, const Stage& stage, double chi2);

/// A step that lowers the objective by less explains what pixels may have wrong in common as well
/// as it does the volume.
double shared_error(const Problem& problem);
/// By the last prediction.
SharedErrors shared_errors_now(const FitRun& run);

}  // namespace kappamu::inverse
