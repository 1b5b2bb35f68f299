// A fit in order: a start, grids coarse to fine and weights strong to weak, a model, checks,
// deviations.
#include "inverse/fit/fit.h"

#include <cmath>
#include <utility>

#include "core/error.h"
#include "inverse/fit/conclusion.h"
#include "inverse/fit/fit_fingerprint.h"
#include "inverse/fit/fit_run.h"
#include "inverse/fit/minimise.h"
#include "inverse/fit/path_rules.h"
#include "inverse/fit/start.h"

namespace kappamu::inverse {

namespace {

GridPath grids_of(const SurfaceMeasurements& measurements, int channel, const FitOptions& options) {
  const DataOptions& data = options.data;
  const bool unweighted = options.regulariser.kind == RegulariserKind::wang2008;
  return {{make_problem(measurements, channel, data.convention, data.model_error),
           data.coarse_model_error, unweighted ? DataWeights::equal : DataWeights::by_variance,
           options.path.max_levels},
          options.solver.backend,
          data.term,
          options.path.correct_grid ? GridCorrection::next_finer : GridCorrection::none};
}

/// On a grid that has just been opened: a weight fixed by the user is the last at once on the
/// finest.
void begin_grid(FitRun& run, double weight) {
  FitState& at = run.state;
  at.weight = weight;
  at.last = run.grid.level() == 0 && run.fixed_weight() && !run.context.interim;
  at.end = PathEnd::unknown;
  at.last_chi2 = at.last_score = 0.0;
}

/// From another fit's volume, on the finest grid, one step of the path above where that ended.
void begin_continued(FitRun& run, const Continuation& from) {
  FitReport& report = run.state.report;
  run.open(0);
  report.homogeneous_kappa = from.homogeneous_kappa;
  report.homogeneous_mu = from.homogeneous_mu;
  report.homogeneous_log_residual = from.homogeneous_log_residual;
  const bool automatic = run.options.data.physics == Physics::automatic;
  run.set_physics(automatic ? from.physics : run.options.data.physics);
  if (automatic) report.physics_reason = from.physics_reason;
  run.state.fields = to_fields(from.medium);
  begin_grid(run, weight_going_on(run.options.path, from.weight));
  run.renew_correction(run.state.fields);
}

/// Homogeneous block, checks of the data, choice of the model. A volume begins on the coarsest
/// grid; a model of few unknowns is the result.
void begin(FitRun& run) {
  const PathOptions& path = run.options.path;
  const GridLevels& levels = run.grid.levels();
  FitReport& report = run.state.report;
  run.open(levels.coarsest());
  Objective& objective = run.grid.objective();
  const HomogeneousFit start = find_start(run);
  report.homogeneous_kappa = start.kappa;
  report.homogeneous_mu = start.mu;
  report.homogeneous_log_residual = start.log_residual;
  const std::size_t cells = run.grid.shape().cells();
  const CoefficientPair fields{Vector(cells, std::log(start.kappa)),
                               Vector(cells, std::log(start.mu))};
  if (path.correct_grid) objective.refresh_correction(run.grid.refinement(), fields);
  report.consistency =
      check_consistency(levels[0], start.kappa, start.mu, run.options.data.model_error,
                        run.options.solver.backend, levels.photons());
  for (const std::string& sentence : warnings_of(report.consistency, levels[0])) run.warn(sentence);
  run.count(report.consistency.solves);
  if (std::optional<SimpleFit> simple = choose_simple_model(run)) {
    conclude_simple(run, std::move(*simple));
    run.state.finished = true;
    return;
  }
  run.state.fields = fields;
  objective.value(fields);
  begin_grid(run, first_weight(path, objective.chi2_per_value()));
}

/// From level 1 to itself closer, or to the next finer grid, where the weight is adapted.
void begin_next_grid(FitRun& run) {
  FitState& at = run.state;
  if (run.grid.go_closer()) {
    run.grid.objective().value(at.fields);
  } else {
    at.fields = run.grid.refine(at.fields);
    run.renew_correction(at.fields);
  }
  const double chi2 = run.grid.objective().chi2_per_value();
  begin_grid(run, weight_on_finer_grid(run.options.path, at.weight, chi2));
}

/// Down the weights of the finest grid to the one that ends the path. That one is minimised again,
/// to a tighter accuracy: those before it only lead there.
void descend(FitRun& run, Stage& stage) {
  const PathOptions& path = run.options.path;
  FitState& at = run.state;
  std::optional<Outlook> ahead;
  for (;;) {
    const Minimum minimum = settle(run, stage);
    ahead = outlook(run, stage, minimum.renewed);
    at.end = end_of_path(path, at.weight, minimum, ahead, at.last_score);
    if (at.end == PathEnd::model_error) break;
    at.last_chi2 = minimum.renewed;
    at.last_score = ahead ? cross_validation(minimum.renewed, ahead->free_share) : 0.0;
    if (at.end != PathEnd::unknown) break;
    at.weight *= path.weight_factor;
    begin_weight(run, stage);
  }
  const bool reverted = at.end == PathEnd::model_error;
  if (reverted) {
    at.fields = stage.begun;
    at.weight /= path.weight_factor;
  }
  at.last = !run.context.interim && needs_tighter_end(path, ahead);
  if (reverted || (at.last && run.grid.levels().photons())) run.renew_correction(at.fields);
  if (!at.last) return;
  if (reverted) {
    begin_weight(run, stage);
  } else {
    repeat_weight(run, stage);
  }
}

/// Grids coarse to fine, on the finest the weights strong to weak, from a weight that has begun.
void follow_path(FitRun& run, Stage& stage) {
  FitState& at = run.state;
  while (run.grid.level() > 0) {
    // A lower weight on a coarse grid fits the grid's own error, along the weakly determined
    // direction.
    settle(run, stage);
    begin_next_grid(run);
    stage = Stage{};
    begin_weight(run, stage);
  }
  if (!at.last) descend(run, stage);
  if (at.last) at.last_chi2 = settle(run, stage).renewed;
  if (run.fixed_weight()) {
    at.end = run.context.continued ? run.context.continued->end : PathEnd::asked;
  }
  conclude(run, stage);
  at.finished = true;
}

/// The volume and what is said of it.
ChannelFit result_of(FitRun& run) {
  const FitState& state = run.state;
  Objective& objective = run.grid.objective();
  run.state.report.chi2_per_value = state.last_chi2;
  run.state.report.weight = state.weight;
  run.state.report.end = state.end;
  objective.value(state.fields);
  run.save();
  ChannelFit fit;
  fit.medium = to_medium(state.fields, run.grid.shape());
  if (!run.context.interim) {
    for (const std::string& sentence :
         volume_warnings(fit.medium, state.report, run.measurements, run.options)) {
      run.warn(sentence);
    }
  }
  run.state.report.shared = shared_errors_now(run);
  const double per_value = exitance_per_value(
      run.measurements, make_setup(run.measurements, run.options.data.convention));
  for (const double p : objective.prediction()) {
    fit.prediction.push_back(static_cast<float>(p / per_value));
  }
  check_data(run);
  find_deviations(run, fit);
  fit.correction = objective.correction();
  fit.simpler = state.simpler;
  fit.report = state.report;
  fit.report.backend = objective.backend_name();
  fit.report.data = run.grid.levels()[0].used();
  fit.report.solves = objective.solves();
  fit.report.seconds = run.seconds();
  return fit;
}

}  // namespace

ChannelFit fit_channel(const SurfaceMeasurements& measurements, int channel,
                       const FitOptions& options, const Checkpoint& checkpoint, Progress& progress,
                       const Observer& observer, const FitContext& context) {
  validate(options);
  validate(measurements, "measurements");
  if (channel < 0 || channel >= static_cast<int>(measurements.channels.size())) {
    throw InputError("measurements: there is no channel " + std::to_string(channel));
  }
  if (context.continued && !(context.continued->medium.kappa.shape() == measurements.grid)) {
    throw InputError("a fit goes on from volumes on the grid of the measurements only");
  }
  FitRun run{measurements,
             channel,
             options,
             checkpoint,
             progress,
             observer,
             context,
             "fit " + measurements.channels[static_cast<std::size_t>(channel)],
             fingerprint(measurements, channel, options, context, checkpoint.program),
             grids_of(measurements, channel, options)};
  Stage stage;
  const bool resumed = resume(run, stage);
  if (!resumed) {
    if (context.continued) {
      begin_continued(run, *context.continued);
    } else {
      begin(run);
    }
    if (!run.state.finished) begin_weight(run, stage);
  }
  if (!run.state.finished) follow_path(run, stage);
  ChannelFit fit = result_of(run);
  fit.report.resumed = resumed;
  return fit;
}

}  // namespace kappamu::inverse
