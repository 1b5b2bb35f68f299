#include "inverse/fit/minimise.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "core/error.h"
#include "inverse/defaults.h"
#include "inverse/fit/fit_run.h"
#include "inverse/on_device/steps.h"
#include "inverse/optimise/lateral_hessian.h"

namespace kappamu::inverse {

namespace {

/// The regulariser of the grid that is fitted.
Regulariser regulariser_of(const FitRun& run) {
  const RegulariserOptions& options = run.options.regulariser;
  Regulariser regulariser{options.kind, options.edge_slope};
  if (regulariser.kind == RegulariserKind::wang2008) {
    // All weights are one, w: ½ w Σ (M − d)² + ½ π² w λ Σ |∇κ|² is ½ π² w times [W] (6), L = M/π.
    const std::vector<double>& weight = run.grid.problem().weight;
    regulariser.scale =
        std::numbers::pi * std::numbers::pi * *std::max_element(weight.begin(), weight.end());
  }
  return regulariser;
}

/// The metric of a weight from the data's Hessian `blocks`, by log κ and a coordinate by which log
/// μ has `slope`.
Basis basis_of(const FitRun& run, double weight, const LateralBlocks& blocks, double slope,
               double off_diagonal_damping) {
  const MediumSpace& space = run.grid.space();
  const SolverOptions& options = run.options.solver;
  const double metric =
      metric_weight(regulariser_of(run), weight, space, run.state.report.homogeneous_kappa);
  return {space,
          BasisOptions{options.coordinates, options.smooth_length * space.thickness_mm, metric,
                       off_diagonal_damping, slope},
          blocks};
}

AbsorptionScale scale_of(const FitRun& run) {
  const bool of_paper = run.options.regulariser.kind == RegulariserKind::wang2008;
  if (of_paper || run.options.solver.coordinates != Coordinates::informed) return {};
  return AbsorptionScale(defaults::little_absorption * run.state.report.homogeneous_mu);
}

void record(FitRun& run, const Stage& stage, double roughness, const CoefficientPair& fields) {
  run.record({.step = stage.steps,
              .objective = stage.optimiser.value,
              .chi2_per_value = stage.chi2,
              .roughness = roughness},
             fields);
}

/// With r renewed, but with the metric and what was learned of the Hessian.
void update_correction(FitRun& run, Stage& stage) {
  stage.optimiser.value = stage.function->value(stage.optimiser.z);
  stage.optimiser.gradient = stage.function->gradient();
  stage.stepping->go_on();
  stage.corrected_chi2 = stage.chi2 = run.grid.objective().chi2_per_value();
  stage.small_decreases = 0;
}

/// Used only when measurement errors are correlated. For white noise a second minimisation at the
/// same weight serves (settle()).
bool correction_is_outdated(const FitRun& run, const Stage& stage) {
  const double target = run.options.path.target_chi2;
  return run.options.path.correct_grid && run.grid.level() == 0 && stage.chi2 <= target &&
         stage.corrected_chi2 > defaults::far_from_noise * target &&
         !run.grid.problem().smooth_error.none();
}

void set_steps(FitRun& run, Stage& stage, VectorPlace place) {
  stage.stepping = std::make_unique<Steps>(run.grid.objective(), *stage.basis, *stage.function,
                                           stage.optimiser, run.options.solver.optimiser, place);
}

/// With the pairs where they are the device's.
void save(FitRun& run, const Stage& stage) {
  if (run.checkpoint.save && stage.stepping) stage.stepping->store();
  run.save(stage);
}

void minimise(FitRun& run, Stage& stage) {
  const double least = tolerance(run.options.path, run.state.last);
  const double shared = shared_error(run.grid.problem());
  const auto found = [&] { return stage.small_decreases >= defaults::few_decreases; };
  const auto out_of_steps = [&] { return stage.steps >= run.options.path.stage_steps; };
  if (!stage.stepping) set_steps(run, stage, run.options.solver.backend.vectors);
  Steps& steps = *stage.stepping;
  while (!found() && !out_of_steps()) {
    const double before = stage.optimiser.value;
    if (steps.step() == StepOutcome::stalled) break;
    ++stage.steps;
    stage.chi2 = run.grid.objective().chi2_per_value();
    const double after = stage.optimiser.value;
    const bool small = before - after < std::max(least * after, shared);
    stage.small_decreases = small ? stage.small_decreases + 1 : 0;
    record(run, stage, steps.roughness(), run.observer ? steps.fields() : CoefficientPair{});
    if (correction_is_outdated(run, stage)) {
      steps.leave();
      run.renew_correction(stage.function->here());
      update_correction(run, stage);
    }
    if (run.since_save.seconds() >= run.checkpoint.interval_seconds) save(run, stage);
  }
  steps.leave();
  stage.ran_out = out_of_steps() && !found();
}

/// The metric and the function, from the fields and the Hessian of the weight's beginning.
void set_function(FitRun& run, Stage& stage) {
  const AbsorptionScale scale = scale_of(run);
  const double weight = run.state.weight;
  stage.basis = std::make_unique<Basis>(basis_of(run, weight, stage.scaled_blocks,
                                                 scale.mean_slope(stage.begun),
                                                 defaults::off_diagonal_damping));
  stage.function = std::make_unique<FitFunction>(run.grid.objective(), *stage.basis, anchor_of(run),
                                                 weight, regulariser_of(run), stage.begun, scale);
}

}  // namespace

void begin_weight(FitRun& run, Stage& stage) {
  const SolverOptions& options = run.options.solver;
  Objective& objective = run.grid.objective();
  const AbsorptionScale scale = scale_of(run);
  stage.begun = run.state.fields;
  if (options.coordinates == Coordinates::informed) {
    // Anew for every weight: the Hessian at the homogeneous start is far from that of a structured
    // block, and a poor metric costs more steps than these solves.
    objective.value(stage.begun);
    std::vector<CoefficientPair> rows = random_rows(objective, options.metric_probes, options.seed);
    stage.blocks = lateral_blocks(rows, run.grid.space());
    for (CoefficientPair& row : rows) row = scale.by_scaled(stage.begun, std::move(row));
    stage.scaled_blocks = lateral_blocks(rows, run.grid.space());
  }
  const std::unique_ptr<Basis> basis_before = std::move(stage.basis);
  const std::unique_ptr<FitFunction> function_before = std::move(stage.function);
  const std::unique_ptr<Steps> steps_before = std::move(stage.stepping);
  set_function(run, stage);
  stage.optimiser.z = stage.function->start_coordinates();
  // Of steps on a device no pair is here.
  restart(*stage.function, stage.optimiser, [&](Vector& step, Vector& change) {
    stage.function->adopt(*function_before, step, change);
  });
  if (steps_before && steps_before->on_device()) {
    set_steps(run, stage, VectorPlace::device);
    stage.stepping->adopt(*steps_before);
  }
  if (!std::isfinite(stage.optimiser.value)) {
    throw InputError(run.stage_name + ": the diffusion solver fails at the starting volume");
  }
  stage.corrected_chi2 = stage.chi2 = objective.chi2_per_value();
  stage.steps = 0;
  stage.small_decreases = 0;
  record(run, stage, stage.function->last_roughness(), stage.begun);
  save(run, stage);
}

void repeat_weight(FitRun& run, Stage& stage) {
  update_correction(run, stage);
  stage.steps = 0;
  record(run, stage, stage.function->last_roughness(), stage.function->here());
  save(run, stage);
}

void restore_weight(FitRun& run, Stage& stage, StageState saved) {
  static_cast<StageState&>(stage) = std::move(saved);
  set_function(run, stage);
  set_steps(run, stage, run.options.solver.backend.vectors);
  stage.stepping->solve();
  stage.stepping->leave();
}

Minimum settle(FitRun& run, Stage& stage) {
  const auto round = [&] {
    minimise(run, stage);
    run.state.fields = stage.function->fields(stage.optimiser.z);
    const double minimised = stage.chi2;
    if (run.state.last && !run.grid.levels().photons() &&
        correction_holds(stage.corrected_chi2, minimised)) {
      run.grid.objective().value(run.state.fields);
      return Minimum{minimised, run.grid.objective().chi2_per_value()};
    }
    // χ² counts with r made here, not with that of the weight's beginning.
    return Minimum{minimised, run.renew_correction(run.state.fields)};
  };
  Minimum minimum = round();
  // Not so where the user fixed the weight from the start, as [W] does.
  const bool may_go_on = !run.fixed_weight() || run.context.continued.has_value();
  if (!stage.again && may_go_on && is_reverted(run.options.path, minimum, run.grid.level() == 0)) {
    stage.again = true;
    repeat_weight(run, stage);
    minimum = round();
  }
  stage.again = false;
  return minimum;
}

double shared_error(const Problem& problem) {
  if (problem.smooth_error.none()) return 0.0;
  double light = 0.0;
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    light += problem.weight[i] * problem.data[i] * problem.data[i];
  }
  return 0.5 * defaults::least_of_light * light;
}

SharedErrors shared_errors_now(const FitRun& run) {
  return shared_errors(run.grid.problem(), run.options.data.term,
                       run.grid.objective().prediction());
}

std::optional<Outlook> outlook(const FitRun& run, const Stage& stage, double chi2) {
  if (run.grid.level() > 0 || stage.blocks.empty()) return {};
  const auto values = static_cast<double>(run.grid.problem().used());
  const auto free_share = [&](const Basis& basis) {
    return 1.0 - basis.determined(stage.blocks) / values;
  };
  const auto by_fields = [&](double weight) {
    return basis_of(run, weight, stage.blocks, 1.0, 0.0);
  };
  Outlook outlook{free_share(by_fields(run.state.weight))};
  // r has had few photons so far, so the last weight is needed.
  outlook.tighter_end_gains =
      run.grid.levels().photons() ||
      shared_error(run.grid.problem()) < run.options.path.stage_tolerance * stage.optimiser.value;
  outlook.excess = shared_errors_now(run).excess;
  const double next = run.state.weight * run.options.path.weight_factor;
  const Basis there = by_fields(next);
  const double gain = stage.function->chi2_gain(run.state.fields, there, next) / values;
  outlook.next_score =
      cross_validation(chi2 - gain, free_share(there)) / cross_validation(chi2, outlook.free_share);
  return outlook;
}

}  // namespace kappamu::inverse
