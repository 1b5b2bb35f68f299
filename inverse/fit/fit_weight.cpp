// One weight of a fit: its metric, the optimiser's steps to the minimum, and what the metric lets
// expect of the next.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "inverse/fit/channel_run.h"
#include "inverse/optimise/lateral_hessian.h"

namespace kappamu::inverse {

namespace {

/// In a row, too small to go on: a single short step is often followed by a long one.
constexpr int few_decreases = 2;
/// Of Σ w d²: what a step must explain of data whose pixels share errors, half a square of the 1e-4
/// that these are of the light where they are least (studies/notes/fit-path.md, "Steps that
/// photographs cannot tell").
constexpr double least_of_light = 5e-9;
/// Times target_chi2: r of a volume that was further from its data is not that of one which
/// explains them (studies/notes/fit-path.md, "Closer before the finest grid, and r on the way").
constexpr double far_from_noise = 6.0;
/// Times μ of the homogeneous block: below it the optimiser moves in log μ, above in μ.
constexpr double little_absorption = 0.2;
/// A wave by itself leaves combinations of depths unseen that it moves together with other waves,
/// where a block varies (studies/notes/fit-path.md).
constexpr double uncoupled_share = 0.5;

}  // namespace

/// What the fields are drawn to.
Anchor ChannelRun::anchor() const {
  return {std::log(state_.report.homogeneous_kappa), std::log(state_.report.homogeneous_mu),
          options_.regulariser.anchor_length * grid_.space().thickness_mm};
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
  const double depth = grid_.space().thickness_mm;
  const double metric =
      metric_weight(regulariser(), weight, grid_.space(), state_.report.homogeneous_kappa);
  return {grid_.space(),
          BasisOptions{options_.solver.coordinates, options_.solver.smooth_length * depth, metric,
                       uncoupled, slope},
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
      std::make_unique<FitFunction>(grid_.objective(), *basis_, anchor(), state_.path.weight,
                                    regulariser(), state_.fields, scale());
}

void ChannelRun::begin_weight() {
  if (options_.solver.coordinates == Coordinates::informed) {
    // Anew for every weight: the Hessian at the homogeneous start is far from that of a structured
    // block, and a poor metric costs more steps than these solves.
    grid_.objective().value(state_.fields);
    std::vector<CoefficientPair> rows =
        random_rows(grid_.objective(), options_.solver.metric_probes, options_.solver.seed);
    state_.blocks = lateral_blocks(rows, grid_.space());
    for (CoefficientPair& row : rows) row = scale().by_scaled(state_.fields, std::move(row));
    state_.scaled_blocks = lateral_blocks(rows, grid_.space());
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
    if (correction_is_outdated()) renew_correction_midway();
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

/// In the middle of a minimisation.
void ChannelRun::renew_correction_midway() {
  renew_correction(function_->fields(state_.optimiser.z));
  meet_correction();
}

/// With r renewed, but with the metric and what was learned of the Hessian.
void ChannelRun::meet_correction() {
  state_.optimiser.value = function_->value(state_.optimiser.z);
  state_.optimiser.gradient = function_->gradient();
  state_.roughness = function_->last_roughness();
  state_.corrected_chi2 = state_.chi2 = grid_.objective().chi2_per_value();
  state_.small_decreases = 0;
}

/// The same weight, from where it has come to, with r renewed.
void ChannelRun::go_on_with_weight() {
  meet_correction();
  state_.stage_steps = 0;
  record();
  save();
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
  // By few photons so far, the last weight is needed.
  outlook.patience_gains = grid_.levels().photons() ||
                           shared_error() < options_.path.stage_tolerance * state_.optimiser.value;
  outlook.excess = shared_errors_now().excess;
  const double next = path_.next_weight();
  const Basis there = by_fields(next);
  const double gain = function_->chi2_gain(state_.fields, there, next) / values;
  outlook.next_score =
      cross_validation(chi2 - gain, free_share(there)) / cross_validation(chi2, outlook.free_share);
  return outlook;
}

}  // namespace kappamu::inverse
