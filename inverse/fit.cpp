#include "inverse/fit.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include "core/error.h"
#include "forward/diffusion_warnings.h"
#include "inverse/basis.h"
#include "inverse/fit_function.h"
#include "inverse/fit_state.h"
#include "inverse/homogeneous.h"
#include "inverse/lateral_hessian.h"
#include "inverse/problem.h"
#include "inverse/roughness.h"
#include "inverse/sensitivity.h"

namespace kappamu::inverse {

namespace {

using Clock = std::chrono::steady_clock;

/// Coarser grids keep at least this many voxels along every axis: fewer resolve neither the decay
/// along the light nor a patch.
constexpr int fewest_voxels = 4;
/// χ² per datum above which stopping there is worth a warning.
constexpr double suspicious_chi2 = 1.5;
/// χ² per datum of a homogeneous start, and of what a coarser grid found, that the weights of the
/// path are made for.
constexpr double usual_homogeneous_chi2 = 100.0;
constexpr double usual_structured_chi2 = 1000.0;

/// χ² of the start counts how much sharper than its structure the data are: where it is large, a
/// usual weight leaps into the nearest valley that explains the data, and a rough one at that. By
/// whole steps of the path, so that where it ends does not hang on χ² of its start.
double sharpened(double weight, double excess, double weight_factor) {
  const double steps = std::ceil(std::log(std::max(1.0, excess)) / -std::log(weight_factor));
  return weight / std::pow(weight_factor, steps);
}

double thickness(const Problem& problem) {
  const GridShape& shape = problem.setup.shape;
  return shape.extent(axis_of(problem.setup.lit_face)) * shape.voxel_mm;
}

std::vector<Problem> make_ladder(const SurfaceMeasurements& measurements, int channel,
                                 const FitOptions& options) {
  std::vector<Problem> ladder;
  ladder.push_back(make_problem(measurements, channel, options.convention, options.model_error));
  while (static_cast<int>(ladder.size()) < options.max_levels) {
    const GridShape& s = ladder.back().setup.shape;
    if (std::min({s.nx, s.ny, s.nz}) < 2 * fewest_voxels) break;
    Problem coarser = coarsen(ladder.back(), options.coarse_model_error);
    if (coarser.used() < 16) break;  // masks left nothing whole
    ladder.push_back(std::move(coarser));
  }
  return ladder;
}

/// One channel's fit; run() from start or checkpoint to the end.
class ChannelRun {
 public:
  ChannelRun(const SurfaceMeasurements& measurements, int channel, const FitOptions& options,
             const Checkpoint& checkpoint, Progress& progress)
      : options_(options),
        checkpoint_(checkpoint),
        progress_(progress),
        stage_name_("fit " + measurements.channels[static_cast<std::size_t>(channel)]),
        fingerprint_(fingerprint(measurements, channel, options)),
        per_value_(exitance_per_value(measurements, make_setup(measurements, options.convention))),
        ladder_(make_ladder(measurements, channel, options)) {}

  ChannelFit run();

 private:
  void open_level();
  void set_basis();
  double refresh_correction();
  void begin();
  void begin_stage();
  void iterate_stage();
  void end_stage();
  void finish_level(bool stagnated);
  ChannelFit result();

  double seconds() const {
    return state_.seconds + std::chrono::duration<double>(Clock::now() - start_).count();
  }
  Refinement refinement() const {
    const auto level = static_cast<std::size_t>(state_.level);
    if (state_.level == 0) return refine(ladder_[0]);
    return {ladder_[level - 1].setup, ladder_[level - 1].irradiance};
  }
  double chi2_per_datum() const {
    const double data = state_.optimiser.value - state_.weight * state_.roughness;
    return 2.0 * data / static_cast<double>(objective_->problem().used());
  }
  void warn(const std::string& sentence);
  void save();
  void record();

  const FitOptions& options_;
  const Checkpoint& checkpoint_;
  Progress& progress_;
  std::string stage_name_;
  std::uint64_t fingerprint_;
  double per_value_;
  std::vector<Problem> ladder_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_save_ = Clock::now();
  FitState state_;
  std::unique_ptr<Objective> objective_;
  std::unique_ptr<Basis> basis_;
  std::unique_ptr<FitFunction> function_;
};

void ChannelRun::warn(const std::string& sentence) {
  auto& warnings = state_.report.warnings;
  if (std::find(warnings.begin(), warnings.end(), sentence) != warnings.end()) return;
  warnings.push_back(sentence);
  progress_.warn(stage_name_ + ": " + sentence);
}

void ChannelRun::save() {
  last_save_ = Clock::now();
  if (!checkpoint_.save) return;
  FitState saved = state_;
  saved.seconds = seconds();
  saved.solves = objective_->solves();
  checkpoint_.save(saved.bytes(fingerprint_));
}

void ChannelRun::record() {
  state_.report.history.push_back({state_.level, state_.weight, state_.stage_steps,
                                   objective_->solves(), state_.optimiser.value, chi2_per_datum(),
                                   state_.roughness, seconds()});
  // Each grid costs eight times the next coarser one: progress counts grids, then weights.
  const double levels = static_cast<double>(ladder_.size());
  const double done = levels - 1.0 - state_.level;
  char detail[128];
  std::snprintf(detail, sizeof detail, "grid %d of %d, weight %.3g, chi2 %.4g, step %d",
                static_cast<int>(done) + 1, static_cast<int>(levels), state_.weight,
                chi2_per_datum(), state_.stage_steps);
  const double reach = 1.0 / std::max(1.0, std::sqrt(chi2_per_datum() / options_.target_chi2));
  progress_.update(stage_name_, std::min(1.0, (done + reach) / levels), detail);
}

void ChannelRun::open_level() {
  const Problem& problem = ladder_[static_cast<std::size_t>(state_.level)];
  objective_ = std::make_unique<Objective>(problem, options_.backend);
  if (!objective_->warning().empty()) warn(objective_->warning());
}

/// The coordinates of this weight; needs state_.blocks.
void ChannelRun::set_basis() {
  const Problem& problem = objective_->problem();
  const double depth = thickness(problem);
  basis_ =
      std::make_unique<Basis>(problem.setup.shape,
                              BasisOptions{options_.coordinates, axis_of(problem.setup.lit_face),
                                           depth, options_.smooth_length * depth, state_.weight},
                              state_.blocks);
  const Anchor anchor{std::log(state_.report.homogeneous_kappa),
                      std::log(state_.report.homogeneous_mu), options_.anchor_length * depth};
  function_ = std::make_unique<FitFunction>(*objective_, *basis_, depth, anchor, state_.weight);
}

void ChannelRun::begin() {
  state_.level = static_cast<int>(ladder_.size()) - 1;
  open_level();
  HomogeneousFit start = fit_homogeneous(*objective_);
  const std::size_t cells = objective_->problem().setup.shape.cells();
  const auto fields = [&] {
    return CoefficientPair{Vector(cells, std::log(start.kappa)), Vector(cells, std::log(start.mu))};
  };
  if (options_.correct_grid) {
    objective_->refresh_correction(refinement(), fields());
    start = fit_homogeneous(*objective_);
    objective_->refresh_correction(refinement(), fields());
  }
  state_.correction = objective_->correction();
  state_.report.homogeneous_kappa = start.kappa;
  state_.report.homogeneous_mu = start.mu;
  state_.report.homogeneous_log_residual = start.log_residual;
  if (!start.converged) {
    warn("The homogeneous start did not converge; the volumes may depend on where it stopped.");
  }
  state_.fields = fields();
  const double chi2 =
      2.0 * objective_->value(state_.fields) / static_cast<double>(objective_->problem().used());
  state_.weight = options_.weight.value_or(
      sharpened(options_.first_weight, chi2 / usual_homogeneous_chi2, options_.weight_factor));
}

/// r anew at the current fields; χ² per datum with it.
double ChannelRun::refresh_correction() {
  const double misfit = options_.correct_grid
                            ? objective_->refresh_correction(refinement(), state_.fields)
                            : objective_->value(state_.fields);
  state_.correction = objective_->correction();
  return 2.0 * misfit / static_cast<double>(objective_->problem().used());
}

void ChannelRun::begin_stage() {
  if (options_.coordinates == Coordinates::informed) {
    // Anew for every weight: the Hessian at the homogeneous start is far from that of a structured
    // block, and a poor metric costs more steps than these solves.
    objective_->value(state_.fields);
    state_.blocks = estimate_lateral_blocks(*objective_, axis_of(ladder_[0].setup.lit_face),
                                            options_.metric_probes, options_.seed);
  }
  set_basis();
  state_.optimiser.z = basis_->from_fields(state_.fields);
  start(*function_, state_.optimiser);
  state_.roughness = function_->last_roughness();
  if (!std::isfinite(state_.optimiser.value)) {
    throw InputError(stage_name_ + ": the diffusion solver fails at the starting volume");
  }
  state_.stage_steps = 0;
  state_.small_decreases = 0;
  state_.in_stage = true;
  record();
  save();
}

void ChannelRun::iterate_stage() {
  state_.ran_out = false;
  // Two in a row: a single short step is often followed by a long one.
  while (state_.small_decreases < 2) {
    if (state_.stage_steps >= options_.stage_steps) {
      state_.ran_out = true;
      break;
    }
    const double before = state_.optimiser.value;
    const StepOutcome outcome = step(*function_, state_.optimiser, options_.optimiser);
    if (outcome == StepOutcome::stalled) break;
    ++state_.stage_steps;
    state_.roughness = function_->last_roughness();
    const double after = state_.optimiser.value;
    const bool small = before - after < options_.stage_tolerance * after;
    state_.small_decreases = small ? state_.small_decreases + 1 : 0;
    record();
    if (std::chrono::duration<double>(Clock::now() - last_save_).count() >=
        checkpoint_.interval_seconds) {
      save();
    }
  }
}

void ChannelRun::end_stage() {
  const double chi2_minimised = chi2_per_datum();
  state_.fields = basis_->to_fields(state_.optimiser.z);
  state_.in_stage = false;
  // What counts is the χ² of a model corrected here, not where this weight was begun.
  const double chi2 = refresh_correction();
  // Where only the correction moved, this weight is low enough: once more with the new one.
  const bool repeat = chi2_minimised <= options_.target_chi2 && !state_.repeated;
  const bool stagnated =
      !repeat && state_.last_chi2 > 0.0 && chi2 > (1.0 - options_.stagnation) * state_.last_chi2;
  const double next = state_.weight * (repeat ? 1.0 : options_.weight_factor);
  state_.repeated = repeat;
  if (options_.weight || chi2 <= options_.target_chi2 || stagnated || next < options_.last_weight) {
    state_.last_chi2 = chi2;
    finish_level(stagnated);
  } else {
    if (!repeat) state_.last_chi2 = chi2;
    state_.weight = next;
  }
}

void ChannelRun::finish_level(bool stagnated) {
  const double chi2 = state_.last_chi2;
  if (state_.level > 0) {
    const GridShape coarse_shape = objective_->problem().setup.shape;
    const SolveCount solves = objective_->solves();
    --state_.level;
    open_level();
    objective_->restore(objective_->correction(), solves);
    const GridShape& shape = objective_->problem().setup.shape;
    state_.fields = {prolong(state_.fields.log_kappa, coarse_shape, shape),
                     prolong(state_.fields.log_mu, coarse_shape, shape)};
    state_.optimiser = OptimiserState{};
    const double chi2_here = refresh_correction();
    if (!options_.weight) {
      const double usual = state_.weight / std::pow(options_.weight_factor, options_.restart_steps);
      state_.weight = sharpened(usual, chi2_here / usual_structured_chi2, options_.weight_factor);
    }
    state_.last_chi2 = 0.0;
    state_.repeated = false;
    return;
  }
  FitReport& report = state_.report;
  char sentence[200];
  if (state_.ran_out) {
    report.status = FitStatus::ran_out;
    std::snprintf(sentence, sizeof sentence,
                  "Stopped after %d steps at one weight, at chi2 per datum %.3g.",
                  options_.stage_steps, chi2);
  } else if (chi2 <= options_.target_chi2 || options_.weight) {
    report.status = FitStatus::converged;
    std::snprintf(sentence, sizeof sentence, "Converged at chi2 per datum %.3g.", chi2);
  } else {
    report.status = stagnated ? FitStatus::above_noise : FitStatus::ran_out;
    std::snprintf(sentence, sizeof sentence, "%s at chi2 per datum %.3g.",
                  stagnated ? "Neither lower weights nor a new correction helped further"
                            : "The lowest weight was reached",
                  chi2);
  }
  report.message = sentence;
  if (chi2 > suspicious_chi2) {
    std::snprintf(sentence, sizeof sentence,
                  "The volumes explain the data only to %.2g times their stated noise (chi2 per "
                  "datum %.3g): variances, calibration or the diffusion model do not hold.",
                  std::sqrt(chi2), chi2);
    warn(sentence);
  }
  report.chi2_per_datum = chi2;
  report.weight = state_.weight;
  state_.finished = true;
  state_.optimiser = OptimiserState{};
  state_.blocks.clear();
  save();
}

ChannelFit ChannelRun::result() {
  const CoefficientPair& fields = state_.fields;
  const GridShape& shape = ladder_[0].setup.shape;
  objective_->value(fields);
  ChannelFit fit;
  fit.medium = {Volume<double>(shape), Volume<double>(shape)};
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    fit.medium.kappa[i] = std::exp(fields.log_kappa[i]);
    fit.medium.mu[i] = std::exp(fields.log_mu[i]);
  }
  for (const std::string& sentence :
       forward::diffusion_warnings(ladder_[0].setup, fit.medium, options_.backend.precision)) {
    warn(sentence);
  }
  for (const double m : objective_->prediction()) {
    fit.prediction.push_back(static_cast<float>(m / per_value_));
  }
  if (options_.sensitivity_probes > 0) {
    CoefficientPair root =
        estimate_sensitivity(*objective_, options_.sensitivity_probes, options_.seed);
    fit.sensitivity_kappa =
        Volume<float>(shape, std::vector<float>(root.log_kappa.begin(), root.log_kappa.end()));
    fit.sensitivity_mu =
        Volume<float>(shape, std::vector<float>(root.log_mu.begin(), root.log_mu.end()));
  }
  fit.report = state_.report;
  fit.report.backend = objective_->backend_name();
  fit.report.data = ladder_[0].used();
  fit.report.seconds = seconds();
  return fit;
}

ChannelFit ChannelRun::run() {
  bool resumed = false;
  if (!checkpoint_.initial.empty()) {
    resumed = state_.restore(checkpoint_.initial, fingerprint_);
    if (!resumed) {
      warn("The checkpoint belongs to other measurements or options; the fit starts anew.");
    }
  }
  if (resumed) {
    open_level();
    objective_->restore(state_.correction, state_.solves);
    if (state_.in_stage) set_basis();
  } else {
    begin();
  }
  while (!state_.finished) {
    if (!state_.in_stage) begin_stage();
    iterate_stage();
    end_stage();
  }
  ChannelFit fit = result();
  fit.report.resumed = resumed;
  return fit;
}

}  // namespace

ChannelFit fit_channel(const SurfaceMeasurements& measurements, int channel,
                       const FitOptions& options, const Checkpoint& checkpoint,
                       Progress& progress) {
  validate(options);
  validate(measurements, "measurements");
  if (channel < 0 || channel >= static_cast<int>(measurements.channels.size())) {
    throw InputError("measurements: there is no channel " + std::to_string(channel));
  }
  return ChannelRun(measurements, channel, options, checkpoint, progress).run();
}

}  // namespace kappamu::inverse
