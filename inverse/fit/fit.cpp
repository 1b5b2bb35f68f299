// The course of a fit: a start, then weight by weight the optimiser's steps.
#include "inverse/fit/fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include "core/error.h"
#include "inverse/block_model/homogeneous.h"
#include "inverse/fit/channel_run.h"
#include "inverse/optimise/lateral_hessian.h"

namespace kappamu::inverse {

void ChannelRun::warn(const std::string& sentence) {
  auto& warnings = state_.report.warnings;
  if (std::find(warnings.begin(), warnings.end(), sentence) != warnings.end()) return;
  warnings.push_back(sentence);
  tell(sentence);
}

void ChannelRun::save() {
  last_save_ = Clock::now();
  if (!checkpoint_.save) return;
  FitState saved = state_;
  saved.seconds = seconds();
  saved.solves = objective_->solves();
  checkpoint_.save(seal(saved.bytes(), origin_));
}

void ChannelRun::record() {
  state_.report.history.push_back({state_.level, state_.path.weight, state_.stage_steps,
                                   objective_->solves(), state_.optimiser.value, state_.chi2,
                                   state_.roughness, seconds()});
  if (observer_) {
    observer_(state_.report.history.back(), objective_->problem().setup.shape,
              basis_->to_fields(state_.optimiser.z));
  }
  // Each grid costs eight times the next coarser one: progress counts grids, then weights.
  const double levels = levels_.count();
  const double done = levels - 1.0 - state_.level;
  char detail[128];
  std::snprintf(detail, sizeof detail, "grid %d of %d, weight %.3g, chi2 %.4g, step %d",
                static_cast<int>(done) + 1, levels_.count(), state_.path.weight, state_.chi2,
                state_.stage_steps);
  const double reach = 1.0 / std::max(1.0, std::sqrt(state_.chi2 / options_.path.target_chi2));
  progress_.update(stage_name_, std::min(1.0, (done + reach) / levels), detail);
}

/// The coordinates of this weight; needs state_.blocks.
void ChannelRun::set_basis() {
  const Problem& problem = objective_->problem();
  const double depth = thickness();
  const Regulariser regulariser = this->regulariser();
  const double metric = metric_weight(regulariser, state_.path.weight, problem.setup.shape, depth,
                                      state_.report.homogeneous_kappa);
  basis_ = std::make_unique<Basis>(
      problem.setup.shape,
      BasisOptions{options_.solver.coordinates, axis_of(problem.setup.lit_face), depth,
                   options_.solver.smooth_length * depth, metric},
      state_.blocks);
  function_ = std::make_unique<FitFunction>(*objective_, *basis_, depth, anchor(),
                                            state_.path.weight, regulariser, state_.fields);
}

/// On the finest grid, from another fit's volume, one step of the path above where it ended.
void ChannelRun::begin_continued(const Continuation& continued) {
  state_.level = 0;
  open_level();
  state_.report.homogeneous_kappa = continued.homogeneous_kappa;
  state_.report.homogeneous_mu = continued.homogeneous_mu;
  state_.report.homogeneous_log_residual = continued.homogeneous_log_residual;
  state_.fields = to_fields(continued.medium);
  choose_physics(continued.homogeneous_kappa, continued.homogeneous_mu);
  refresh_correction();
  path_.start_from(continued.weight);
}

void ChannelRun::begin() {
  if (context_.continued) return begin_continued(*context_.continued);
  state_.level = levels_.coarsest();
  open_level();
  HomogeneousFit start;
  try {
    const PathOptions& path = options_.path;
    std::optional<HomogeneousGuess> guess;
    if (path.start_kappa) guess = {*path.start_kappa, path.start_mu.value()};
    start = fit_homogeneous(*objective_, guess);
  } catch (const InputError& error) {
    throw InputError(stage_name_ + ": " + error.what());
  }
  const std::size_t cells = objective_->problem().setup.shape.cells();
  const auto fields = [&] {
    return CoefficientPair{Vector(cells, std::log(start.kappa)), Vector(cells, std::log(start.mu))};
  };
  if (options_.path.correct_grid) {
    objective_->refresh_correction(levels_.refinement(state_.level), fields());
    start = refit_homogeneous(*objective_, start);
  }
  choose_physics(start.kappa, start.mu);
  if (state_.report.physics == Physics::transport) start = refit_by_transport(start);
  if (options_.path.correct_grid) {
    objective_->refresh_correction(levels_.refinement(state_.level), fields());
  }
  state_.correction = objective_->correction();
  state_.report.homogeneous_kappa = start.kappa;
  state_.report.homogeneous_mu = start.mu;
  state_.report.homogeneous_log_residual = start.log_residual;
  if (!start.converged) {
    warn("The homogeneous start did not converge; the volumes may depend on where it stopped.");
  }
  state_.report.consistency =
      check_consistency(levels_[0], start.kappa, start.mu, options_.data.model_error,
                        options_.solver.backend, levels_.photons());
  for (const std::string& sentence : warnings_of(state_.report.consistency, levels_[0])) {
    warn(sentence);
  }
  SolveCount solves = objective_->solves();
  solves.add(state_.report.consistency.solves);
  objective_->restore(objective_->correction(), solves);
  if (settle_for_simple_model()) return;
  state_.fields = fields();
  objective_->value(state_.fields);
  path_.start(objective_->chi2_per_value(), state_.level);
}

void ChannelRun::begin_weight() {
  if (options_.solver.coordinates == Coordinates::informed) {
    // Anew for every weight: the Hessian at the homogeneous start is far from that of a structured
    // block, and a poor metric costs more steps than these solves.
    objective_->value(state_.fields);
    state_.blocks = estimate_lateral_blocks(*objective_, axis_of(levels_[0].setup.lit_face),
                                            options_.solver.metric_probes, options_.solver.seed);
  }
  const std::unique_ptr<Basis> basis_before = std::move(basis_);
  const std::unique_ptr<FitFunction> function_before = std::move(function_);
  set_basis();
  state_.optimiser.z = basis_->from_fields(state_.fields);
  // What the weight before learned of the Hessian holds here too (none on a new grid).
  restart(*function_, state_.optimiser,
          [&](Vector& step, Vector& change) { function_->adopt(*function_before, step, change); });
  state_.roughness = function_->last_roughness();
  state_.chi2 = objective_->chi2_per_value();
  state_.path.begun_chi2 = state_.chi2;
  if (!std::isfinite(state_.optimiser.value)) {
    throw InputError(stage_name_ + ": the diffusion solver fails at the starting volume");
  }
  state_.stage_steps = 0;
  state_.small_decreases = 0;
  record();
  save();
}

ChannelRun::StepsEnd ChannelRun::minimise() {
  // Two in a row: a single short step is often followed by a long one.
  while (state_.small_decreases < 2) {
    if (state_.stage_steps >= options_.path.stage_steps) return StepsEnd::stage_steps;
    const double before = state_.optimiser.value;
    const StepOutcome outcome = step(*function_, state_.optimiser, options_.solver.optimiser);
    if (outcome == StepOutcome::stalled) break;
    ++state_.stage_steps;
    state_.roughness = function_->last_roughness();
    state_.chi2 = objective_->chi2_per_value();
    const double after = state_.optimiser.value;
    const bool small = before - after < path_.tolerance() * after;
    state_.small_decreases = small ? state_.small_decreases + 1 : 0;
    record();
    if (std::chrono::duration<double>(Clock::now() - last_save_).count() >=
        checkpoint_.interval_seconds) {
      save();
    }
  }
  return StepsEnd::minimum;
}

ChannelFit ChannelRun::run() {
  const bool resumed = resume();
  if (!resumed) {
    begin();
    if (state_.path.phase != FitPhase::finished) begin_weight();
  }
  while (state_.path.phase != FitPhase::finished) follow_path(minimise());
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
