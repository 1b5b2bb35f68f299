// A fit in order: a start, then the optimiser's steps at one weight after another, grid by
// grid.
#include "inverse/fit/fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "inverse/block_model/homogeneous.h"
#include "inverse/fit/channel_run.h"
#include "inverse/fit/fit_fingerprint.h"
#include "inverse/optimise/lateral_hessian.h"

namespace kappamu::inverse {

namespace {

/// In a row, too small to go on: a single short step is often followed by a long one.
constexpr int few_decreases = 2;
/// Of Σ w d²: what a step must explain of data whose pixels share errors, half a square of the 1e-4
/// that these are of the light where they are least (docs/notes/fit-path.md, "Steps that
/// photographs cannot tell").
constexpr double least_of_light = 5e-9;
/// Times target_chi2: r of a volume that was further from its data is not that of one which
/// explains them (docs/notes/fit-path.md, "Closer before the finest grid, and r on the way").
constexpr double far_from_noise = 6.0;
/// Times μ of the homogeneous block: below it the optimiser moves in log μ, above in μ.
constexpr double little_absorption = 0.2;
/// A wave by itself leaves combinations of depths unseen that it moves together with other waves,
/// where a block varies (docs/notes/fit-path.md).
constexpr double uncoupled_share = 0.5;

}  // namespace

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

/// What the fields are drawn to.
Anchor ChannelRun::anchor() const {
  return {std::log(state_.report.homogeneous_kappa), std::log(state_.report.homogeneous_mu),
          options_.regulariser.anchor_length * grid_.thickness_mm()};
}

Regulariser ChannelRun::regulariser() const {
  Regulariser regulariser{options_.regulariser.kind, options_.regulariser.edge_slope};
  if (regulariser.kind == RegulariserKind::wang2008) {
    // All weights are one, w: ½ w Σ (M − d)² + ½ π² w λ Σ |∇κ|² is ½ π² w times [W] (6), L = M/π.
    const std::vector<double>& weight = grid_.problem().weight;
    regulariser.scale =
        std::numbers::pi * std::numbers::pi * *std::max_element(weight.begin(), weight.end());
  }
  return regulariser;
}

/// The metric of a weight from the data's Hessian `blocks`, by log κ and a coordinate by which log
/// μ has `slope`.
Basis ChannelRun::basis(double weight, const LateralBlocks& blocks, double slope,
                        double uncoupled) const {
  const double depth = grid_.thickness_mm();
  const double metric =
      metric_weight(regulariser(), weight, grid_.shape(), depth, state_.report.homogeneous_kappa);
  return {grid_.shape(),
          BasisOptions{options_.solver.coordinates, axis_of(grid_.problem().setup.lit_face), depth,
                       options_.solver.smooth_length * depth, metric, uncoupled, slope},
          blocks};
}

AbsorptionScale ChannelRun::scale() const {
  const bool of_paper = options_.regulariser.kind == RegulariserKind::wang2008;
  if (of_paper || options_.solver.coordinates != Coordinates::informed) return {};
  return AbsorptionScale(little_absorption * state_.report.homogeneous_mu);
}

/// Needs state_.scaled_blocks and the fields that they were estimated at.
void ChannelRun::set_basis() {
  const double slope = scale().mean_slope(state_.fields);
  basis_ = std::make_unique<Basis>(
      basis(state_.path.weight, state_.scaled_blocks, slope, uncoupled_share));
  function_ =
      std::make_unique<FitFunction>(grid_.objective(), *basis_, grid_.thickness_mm(), anchor(),
                                    state_.path.weight, regulariser(), state_.fields, scale());
}

/// On the finest grid, from another fit's volume, one step of the path above where it ended.
void ChannelRun::begin_continued(const Continuation& continued) {
  open(0);
  state_.report.homogeneous_kappa = continued.homogeneous_kappa;
  state_.report.homogeneous_mu = continued.homogeneous_mu;
  state_.report.homogeneous_log_residual = continued.homogeneous_log_residual;
  state_.fields = to_fields(continued.medium);
  choose_physics(continued.homogeneous_kappa, continued.homogeneous_mu);
  grid_.renew_correction(state_.fields);
  path_.start_from(continued.weight);
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
    start = fit_homogeneous(objective, guess);
  } catch (const InputError& error) {
    throw InputError(stage_name_ + ": " + error.what());
  }
  const auto fields = [&] {
    const std::size_t cells = grid_.shape().cells();
    return CoefficientPair{Vector(cells, std::log(start.kappa)), Vector(cells, std::log(start.mu))};
  };
  if (options_.path.correct_grid) {
    objective.refresh_correction(grid_.refinement(), fields());
    start = refit_homogeneous(objective, start);
  }
  choose_physics(start.kappa, start.mu);
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

void ChannelRun::begin_weight() {
  if (options_.solver.coordinates == Coordinates::informed) {
    // Anew for every weight: the Hessian at the homogeneous start is far from that of a structured
    // block, and a poor metric costs more steps than these solves.
    grid_.objective().value(state_.fields);
    std::vector<CoefficientPair> rows =
        random_rows(grid_.objective(), options_.solver.metric_probes, options_.solver.seed);
    const int axis = axis_of(grid_.problem().setup.lit_face);
    state_.blocks = lateral_blocks(rows, grid_.shape(), axis);
    for (CoefficientPair& row : rows) row = scale().by_scaled(state_.fields, std::move(row));
    state_.scaled_blocks = lateral_blocks(rows, grid_.shape(), axis);
  }
  const std::unique_ptr<Basis> basis_before = std::move(basis_);
  const std::unique_ptr<FitFunction> function_before = std::move(function_);
  set_basis();
  state_.optimiser.z = function_->coordinates(state_.fields);
  // What the weight before learned of the Hessian holds here too (none on a new grid).
  restart(*function_, state_.optimiser,
          [&](Vector& step, Vector& change) { function_->adopt(*function_before, step, change); });
  state_.roughness = function_->last_roughness();
  state_.corrected_chi2 = state_.chi2 = grid_.objective().chi2_per_value();
  if (!std::isfinite(state_.optimiser.value)) {
    throw InputError(stage_name_ + ": the diffusion solver fails at the starting volume");
  }
  state_.stage_steps = 0;
  state_.small_decreases = 0;
  record();
  save();
}

void ChannelRun::minimise() {
  while (state_.small_decreases < few_decreases && !out_of_steps()) {
    const double before = state_.optimiser.value;
    const StepOutcome outcome = step(*function_, state_.optimiser, options_.solver.optimiser);
    if (outcome == StepOutcome::stalled) break;
    ++state_.stage_steps;
    state_.roughness = function_->last_roughness();
    state_.chi2 = grid_.objective().chi2_per_value();
    const double after = state_.optimiser.value;
    const bool small = before - after < std::max(path_.tolerance() * after, shared_error());
    state_.small_decreases = small ? state_.small_decreases + 1 : 0;
    record();
    if (correction_is_outdated()) renew_correction();
    if (since_save_.seconds() >= checkpoint_.interval_seconds) {
      save();
    }
  }
}

/// Asked of data whose pixels share errors; where noise is white the rounds of a weight find out.
bool ChannelRun::correction_is_outdated() const {
  const double target = options_.path.target_chi2;
  return options_.path.correct_grid && grid_.level() == 0 && state_.chi2 <= target &&
         state_.corrected_chi2 > far_from_noise * target && !grid_.problem().smooth_error.none();
}

/// In the middle of a minimisation, which goes on with what it has learned of the Hessian.
void ChannelRun::renew_correction() {
  grid_.renew_correction(function_->fields(state_.optimiser.z));
  state_.optimiser.value = function_->value(state_.optimiser.z);
  state_.optimiser.gradient = function_->gradient();
  state_.corrected_chi2 = state_.chi2 = grid_.objective().chi2_per_value();
  state_.small_decreases = 0;
}

/// A step that lowers the objective by less explains what pixels may have wrong in common as well
/// as it does the volume.
double ChannelRun::shared_error() const {
  const Problem& problem = grid_.problem();
  if (problem.smooth_error.none()) return 0.0;
  double light = 0.0;
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    light += problem.weight[i] * problem.data[i] * problem.data[i];
  }
  return 0.5 * least_of_light * light;
}

bool ChannelRun::out_of_steps() const {
  return state_.stage_steps >= options_.path.stage_steps && state_.small_decreases < few_decreases;
}

void ChannelRun::follow_path() {
  CoefficientPair begun = std::move(state_.fields);
  state_.fields = function_->fields(state_.optimiser.z);
  // What counts is the χ² of a model corrected here, not where this weight was begun.
  const double renewed = grid_.renew_correction(state_.fields);
  const NextStep next = path_.minimum(state_.chi2, renewed, outlook(renewed), grid_.level());
  if (next.from == NextStep::From::begun) {
    state_.fields = std::move(begun);
    grid_.renew_correction(state_.fields);
  }
  if (next.what == NextStep::What::conclude) return conclude();
  if (next.what == NextStep::What::finer_grid) {
    state_.optimiser = OptimiserState{};
    if (grid_.go_closer()) {
      grid_.objective().value(state_.fields);
    } else {
      state_.fields = grid_.refine(state_.fields);
      grid_.renew_correction(state_.fields);
    }
    path_.refine(grid_.objective().chi2_per_value(), grid_.level());
  }
  begin_weight();
}

/// By the metric; empty where there is none, and on coarser grids, whose path does not ask.
std::optional<Outlook> ChannelRun::outlook(double chi2) const {
  if (grid_.level() > 0 || options_.solver.coordinates != Coordinates::informed ||
      state_.blocks.empty())
    return {};
  const auto values = static_cast<double>(grid_.problem().used());
  const auto free_share = [&](const Basis& basis) {
    const Basis::Determined determined = basis.determined(state_.blocks);
    return 1.0 - (determined.kappa + determined.mu) / values;
  };
  const auto by_fields = [&](double weight) { return basis(weight, state_.blocks, 1.0, 0.0); };
  Outlook outlook{free_share(by_fields(state_.path.weight))};
  outlook.patience_gains = shared_error() < options_.path.stage_tolerance * state_.optimiser.value;
  const double next = path_.next_weight();
  const Basis there = by_fields(next);
  const double gain = function_->chi2_gain(state_.fields, there, next) / values;
  outlook.next_score =
      cross_validation(chi2 - gain, free_share(there)) / cross_validation(chi2, outlook.free_share);
  return outlook;
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
