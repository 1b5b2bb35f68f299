// A fit in order: a start, then one weight after another, grid by grid.
#include "inverse/fit/fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/error.h"
#include "inverse/block_model/homogeneous.h"
#include "inverse/fit/channel_run.h"
#include "inverse/fit/fit_fingerprint.h"

namespace kappamu::inverse {

GridPath make_grid_path(const SurfaceMeasurements& measurements, int channel,
                        const FitOptions& options) {
  const DataOptions& data = options.data;
  const bool unweighted = options.regulariser.kind == RegulariserKind::wang2008;
  return {{make_problem(measurements, channel, data.convention, data.model_error),
           data.coarse_model_error, unweighted ? DataWeights::equal : DataWeights::by_variance,
           options.path.max_levels},
          options.solver.backend,
          data.term,
          options.path.correct_grid ? GridCorrection::next_finer : GridCorrection::none};
}

ChannelRun::ChannelRun(const SurfaceMeasurements& measurements, int channel,
                       const FitOptions& options, const Checkpoint& checkpoint, Progress& progress,
                       const Observer& observer, const FitContext& context)
    : measurements_(measurements),
      options_(options),
      checkpoint_(checkpoint),
      progress_(progress),
      observer_(observer),
      context_(context),
      channel_(channel),
      stage_name_("fit " + measurements.channels[static_cast<std::size_t>(channel)]),
      origin_{fingerprint(measurements, channel, options, context),
              program_fingerprint(checkpoint.program, options.solver.backend)},
      per_value_(
          exitance_per_value(measurements, make_setup(measurements, options.data.convention))),
      grid_(make_grid_path(measurements, channel, options)) {}

void ChannelRun::warn(const std::string& sentence) {
  auto& warnings = state_.report.warnings;
  if (std::find(warnings.begin(), warnings.end(), sentence) != warnings.end()) return;
  warnings.push_back(sentence);
  tell(sentence);
}

void ChannelRun::save() {
  since_save_ = Stopwatch{};
  if (!checkpoint_.save) return;
  FitState saved = state_;
  saved.seconds = seconds();
  saved.level = grid_.level();
  saved.closer = grid_.closer();
  saved.correction = grid_.objective().correction();
  saved.solves = grid_.objective().solves();
  checkpoint_.save(seal(saved.bytes(), origin_));
}

void ChannelRun::record() {
  state_.report.history.push_back({grid_.level(), state_.path.weight, state_.stage_steps,
                                   grid_.objective().solves(), state_.optimiser.value, state_.chi2,
                                   state_.roughness, seconds()});
  if (observer_) {
    observer_(state_.report.history.back(), grid_.shape(), function_->fields(state_.optimiser.z));
  }
  // Each grid costs eight times the next coarser one: progress counts grids, then weights.
  const int levels = grid_.levels().count();
  const int done = levels - 1 - grid_.level();
  char detail[128];
  std::snprintf(detail, sizeof detail, "grid %d of %d, weight %.3g, chi2 %.4g, step %d", done + 1,
                levels, state_.path.weight, state_.chi2, state_.stage_steps);
  const double reach = 1.0 / std::max(1.0, std::sqrt(state_.chi2 / options_.path.target_chi2));
  progress_.update(stage_name_, std::min(1.0, (done + reach) / levels), detail);
}

void ChannelRun::open(int level, bool closer) {
  grid_.open(level, closer);
  if (!grid_.objective().warning().empty()) warn(grid_.objective().warning());
}

/// On the finest grid, from another fit's volume, one step of the path above where it ended.
void ChannelRun::begin_continued(const Continuation& continued) {
  open(0);
  state_.report.homogeneous_kappa = continued.homogeneous_kappa;
  state_.report.homogeneous_mu = continued.homogeneous_mu;
  state_.report.homogeneous_log_residual = continued.homogeneous_log_residual;
  state_.fields = to_fields(continued.medium);
  if (options_.data.physics == Physics::automatic) {
    set_physics(continued.physics);
    state_.report.physics_reason = continued.physics_reason;
  } else {
    set_physics(options_.data.physics);
  }
  path_.start_from(continued.weight);
  renew_correction(state_.fields);
  if (options_.path.weight) state_.path.end = continued.end;
}

void ChannelRun::begin() {
  if (context_.continued) return begin_continued(*context_.continued);
  open(grid_.levels().coarsest());
  Objective& objective = grid_.objective();
  HomogeneousFit start;
  try {
    const PathOptions& path = options_.path;
    std::optional<HomogeneousGuess> guess;
    if (path.start_kappa) guess = {*path.start_kappa, path.start_mu.value()};
    start = find_homogeneous(grid_.levels()[0], guess);
  } catch (const InputError& error) {
    throw InputError(stage_name_ + ": " + error.what(), error.options());
  }
  const auto fields = [&] {
    const std::size_t cells = grid_.shape().cells();
    return CoefficientPair{Vector(cells, std::log(start.kappa)), Vector(cells, std::log(start.mu))};
  };
  choose_physics(start);
  if (state_.report.physics == Physics::transport) start = refit_by_transport(start);
  if (options_.path.correct_grid) objective.refresh_correction(grid_.refinement(), fields());
  state_.report.homogeneous_kappa = start.kappa;
  state_.report.homogeneous_mu = start.mu;
  state_.report.homogeneous_log_residual = start.log_residual;
  if (!start.converged) {
    warn("The homogeneous start did not converge; the volumes may depend on where it stopped.");
  }
  const GridLevels& levels = grid_.levels();
  Consistency& consistency = state_.report.consistency;
  consistency = check_consistency(levels[0], start.kappa, start.mu, options_.data.model_error,
                                  options_.solver.backend, levels.photons());
  for (const std::string& sentence : warnings_of(consistency, levels[0])) warn(sentence);
  SolveCount solves = objective.solves();
  solves.add(consistency.solves);
  objective.restore(objective.correction(), solves);
  if (settle_for_simple_model()) return;
  state_.fields = fields();
  objective.value(state_.fields);
  path_.start(objective.chi2_per_value(), grid_.level());
}

/// r anew; χ² per value with it. On the way to the last weight, where r and the volume still move
/// more, by a quarter of the photons.
double ChannelRun::renew_correction(const CoefficientPair& fields) {
  constexpr double noise_midway = 2.0;
  return grid_.renew_correction(fields, path_.at_last_weight() ? 1.0 : noise_midway);
}

void ChannelRun::follow_path() {
  CoefficientPair begun = std::move(state_.fields);
  state_.fields = function_->fields(state_.optimiser.z);
  const double weight = state_.path.weight;
  // What counts is the χ² of a model corrected here, not where this weight was begun.
  const double renewed = renew_correction(state_.fields);
  const bool was_last = path_.at_last_weight();
  const NextStep next = path_.minimum(state_.chi2, renewed, outlook(renewed), grid_.level());
  bool outdated = next.from == NextStep::From::begun;
  if (outdated) state_.fields = std::move(begun);
  if (next.what == NextStep::What::finer_grid) {
    state_.optimiser = OptimiserState{};
    outdated = false;
    if (grid_.go_closer()) {
      grid_.objective().value(state_.fields);
    } else {
      state_.fields = grid_.refine(state_.fields);
      renew_correction(state_.fields);
    }
    path_.refine(grid_.objective().chi2_per_value(), grid_.level());
  }
  const bool by_few_photons = grid_.levels().photons() && !was_last && path_.at_last_weight();
  if (outdated || by_few_photons) renew_correction(state_.fields);
  if (next.what == NextStep::What::conclude) return conclude();
  if (next.what == NextStep::What::minimise && state_.path.weight == weight) {
    state_.fields = std::move(begun);
    go_on_with_weight();
  } else {
    begin_weight();
  }
}

ChannelFit ChannelRun::run() {
  const bool resumed = resume();
  if (!resumed) {
    begin();
    if (state_.path.phase != FitPhase::finished) begin_weight();
  }
  while (state_.path.phase != FitPhase::finished) {
    minimise();
    follow_path();
  }
  ChannelFit fit = result();
  fit.report.resumed = resumed;
  return fit;
}

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
  return ChannelRun(measurements, channel, options, checkpoint, progress, observer, context).run();
}

}  // namespace kappamu::inverse
