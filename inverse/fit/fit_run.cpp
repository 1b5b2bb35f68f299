#include "inverse/fit/fit_run.h"

#include <algorithm>
#include <cmath>

#include "core/shown_text.h"
#include "inverse/checkpoint/checkpoint.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

void FitRun::warn(const std::string& sentence) {
  auto& warnings = state.report.warnings;
  if (std::find(warnings.begin(), warnings.end(), sentence) != warnings.end()) return;
  warnings.push_back(sentence);
  progress.warn(stage_name + ": " + sentence);
}

void FitRun::count(const SolveCount& solves) {
  SolveCount sum = grid.objective().solves();
  sum.add(solves);
  grid.objective().restore(grid.objective().correction(), sum);
}

void FitRun::record(StepRecord step, const CoefficientPair& fields) {
  step.level = grid.level();
  step.weight = state.weight;
  step.solves = grid.objective().solves();
  step.seconds = seconds();
  state.report.history.push_back(step);
  if (observer) observer(step, grid.shape(), fields);
  // Each grid costs eight times the next coarser one: progress counts grids, then weights.
  const int levels = grid.levels().count();
  const int done = levels - 1 - grid.level();
  const double reach =
      1.0 / std::max(1.0, std::sqrt(step.chi2_per_value / options.path.target_chi2));
  progress.update(stage_name, std::min(1.0, (done + reach) / levels),
                  formatted("grid %d of %d, weight %.3g, chi2 %.4g, step %d", done + 1, levels,
                            step.weight, step.chi2_per_value, step.step));
}

void FitRun::save(const StageState& stage) {
  since_save = Stopwatch{};
  if (!checkpoint.save) return;
  FitState saved = state;
  saved.seconds = seconds();
  saved.level = grid.level();
  saved.closer = grid.closer();
  saved.solves = grid.objective().solves();
  saved.correction = grid.objective().correction();
  saved.stage = stage;
  checkpoint.save(seal(saved.bytes(), origin));
}

void FitRun::open(int level, bool closer) {
  grid.open(level, closer);
  if (!grid.objective().warning().empty()) warn(grid.objective().warning());
}

void FitRun::set_physics(Physics physics) {
  state.report.physics = physics;
  grid.set_photons(predict_options(options, physics).photons);
}

double FitRun::renew_correction(const CoefficientPair& fields) {
  const bool exact = state.last || state.finished;
  return grid.renew_correction(fields, exact ? 1.0 : defaults::photon_noise_midway);
}

Anchor anchor_of(const FitRun& run) {
  const FitReport& report = run.state.report;
  return {std::log(report.homogeneous_kappa), std::log(report.homogeneous_mu),
          run.options.regulariser.anchor_length * run.grid.space().thickness_mm};
}

Prior prior_of(const FitRun& run) {
  return {run.state.weight, anchor_of(run).length_mm};
}

}  // namespace kappamu::inverse
