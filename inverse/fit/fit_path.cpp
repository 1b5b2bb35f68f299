// The path of a fit: from the coarsest grid to the finest, and on each from a strong weight α down
// to the noise level.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "core/median.h"
#include "inverse/fit/channel_run.h"
#include "inverse/fit/fit_fingerprint.h"

namespace kappamu::inverse {

namespace {

/// Coarser grids keep at least this many voxels along every axis: fewer resolve neither the decay
/// along the light nor a patch.
constexpr int fewest_voxels = 4;
/// χ² per value of a homogeneous start, and of what a coarser grid found, that the weights of the
/// path are made for.
constexpr double usual_homogeneous_chi2 = 100.0;
constexpr double usual_structured_chi2 = 1000.0;
/// A weight on a coarser grid is worth having where χ², r renewed, reaches the noise level or falls
/// to this share of what it was (docs/theory.md, section 4).
constexpr double most_coarse_share = 0.5;

/// Solves err by this share of a datum's usual deviation, but by no more than the second: fits end
/// at the same E as with exact ones (docs/theory.md, section 4).
constexpr double solver_share_of_noise = 0.1;
constexpr double loosest_solve = 1e-3;

/// `backend` with solves as loose as the data allow; refined ones, few, stay exact: r corrects all
/// the data.
Backend suited(Backend backend, const Problem& problem) {
  std::vector<double> deviations;  // relative
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    if (problem.weight[i] == 0.0 || problem.data[i] == 0.0) continue;
    deviations.push_back(1.0 / (std::sqrt(problem.weight[i]) * std::abs(problem.data[i])));
  }
  if (deviations.empty()) return backend;
  const double allowed =
      std::min(loosest_solve, solver_share_of_noise * upper_median(std::move(deviations)));
  backend.solve.tolerance = std::max(backend.solve.tolerance, allowed);
  return backend;
}

/// χ² of the start counts how much sharper than its structure the data are: where it is large, a
/// usual weight leaps into the nearest valley that explains the data, and a rough one at that. By
/// whole steps of the path, so that where it ends does not hang on χ² of its start.
double sharpened(double weight, double excess, double weight_factor) {
  const double steps = std::ceil(std::log(std::max(1.0, excess)) / -std::log(weight_factor));
  return weight / std::pow(weight_factor, steps);
}

std::vector<Problem> make_ladder(const SurfaceMeasurements& measurements, int channel,
                                 const FitOptions& options) {
  std::vector<Problem> ladder;
  ladder.push_back(
      make_problem(measurements, channel, options.data.convention, options.data.model_error));
  const bool unweighted = options.regulariser.kind == RegulariserKind::wang2008;
  if (unweighted) equalise_weights(ladder.back());
  while (static_cast<int>(ladder.size()) < options.path.max_levels) {
    const GridShape& s = ladder.back().setup.shape;
    if (std::min({s.nx, s.ny, s.nz}) < 2 * fewest_voxels) break;
    Problem coarser = coarsen(ladder.back(), options.data.coarse_model_error);
    if (coarser.used() < 16) break;  // masks left nothing whole
    if (unweighted) equalise_weights(coarser);
    ladder.push_back(std::move(coarser));
  }
  return ladder;
}

}  // namespace

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
      ladder_(make_ladder(measurements, channel, options)) {}

void ChannelRun::open_level() {
  const Problem& problem = ladder_[static_cast<std::size_t>(state_.level)];
  objective_ = std::make_unique<Objective>(problem, suited(options_.solver.backend, problem),
                                           options_.data.term);
  if (!objective_->warning().empty()) warn(objective_->warning());
}

/// ℓ [mm].
double ChannelRun::thickness() const {
  const GridShape& shape = objective_->problem().setup.shape;
  return shape.extent(axis_of(objective_->problem().setup.lit_face)) * shape.voxel_mm;
}

/// What the fields are drawn to.
Anchor ChannelRun::anchor() const {
  return {std::log(state_.report.homogeneous_kappa), std::log(state_.report.homogeneous_mu),
          options_.regulariser.anchor_length * thickness()};
}

Regulariser ChannelRun::regulariser() const {
  Regulariser regulariser{options_.regulariser.kind, options_.regulariser.edge_slope};
  if (regulariser.kind == RegulariserKind::wang2008) {
    // All weights are one, w: ½ w Σ (M − d)² + ½ π² w λ Σ |∇κ|² is ½ π² w times [W] (6), L = M/π.
    const std::vector<double>& weight = objective_->problem().weight;
    regulariser.scale =
        std::numbers::pi * std::numbers::pi * *std::max_element(weight.begin(), weight.end());
  }
  return regulariser;
}

/// r anew at the current fields; χ² per value with it.
double ChannelRun::refresh_correction() {
  if (options_.path.correct_grid) {
    objective_->refresh_correction(refinement(), state_.fields);
  } else {
    objective_->value(state_.fields);
  }
  state_.correction = objective_->correction();
  return objective_->chi2_per_value();
}

/// α that opens the path, χ² per value being that of the homogeneous start.
double ChannelRun::first_weight(double chi2) const {
  return options_.path.weight.value_or(sharpened(
      options_.path.first_weight, chi2 / usual_homogeneous_chi2, options_.path.weight_factor));
}

void ChannelRun::end_stage() {
  const double chi2_minimised = state_.chi2;
  CoefficientPair begun = std::move(state_.fields);
  state_.fields = basis_->to_fields(state_.optimiser.z);
  state_.in_stage = false;
  // What counts is the χ² of a model corrected here, not where this weight was begun.
  const double chi2 = refresh_correction();
  // χ² by the new r is back above the noise: this weight is low enough, the volume not yet there.
  // Not so where the user fixed it from the start, as [W] does.
  const bool unsettled = (!options_.path.weight || context_.continued) && !state_.repeated &&
                         chi2_minimised <= options_.path.target_chi2 &&
                         chi2 > options_.path.target_chi2;
  if (state_.last_stage) {
    state_.last_chi2 = chi2;
    if (!unsettled) return conclude();
    state_.repeated = true;
    return;
  }
  // Where r, renewed, takes back what a weight gained on a coarser grid, the volume answers the
  // grid's own error: the one before is where the finer grid goes on, under a stronger weight.
  const bool gained =
      chi2 <= std::max(options_.path.target_chi2, most_coarse_share * state_.begun_chi2);
  if (state_.level > 0 && !options_.path.weight && !gained) {
    state_.fields = std::move(begun);
    state_.weight /= options_.path.weight_factor;
    return finish_level();
  }
  const bool stagnated = !unsettled && state_.last_chi2 > 0.0 &&
                         chi2 > (1.0 - options_.path.stagnation) * state_.last_chi2;
  const double next = state_.weight * (unsettled ? 1.0 : options_.path.weight_factor);
  state_.repeated = unsettled;
  if (options_.path.weight || chi2 <= options_.path.target_chi2 || stagnated ||
      next < options_.path.last_weight) {
    state_.last_chi2 = chi2;
    state_.stagnated = stagnated;
    finish_level();
  } else {
    if (!unsettled) state_.last_chi2 = chi2;
    state_.weight = next;
  }
}

void ChannelRun::finish_level() {
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
    if (!options_.path.weight) {
      const double usual =
          state_.weight / std::pow(options_.path.weight_factor, options_.path.restart_steps);
      state_.weight =
          sharpened(usual, chi2_here / usual_structured_chi2, options_.path.weight_factor);
    }
    state_.last_chi2 = 0.0;
    state_.repeated = false;
    state_.last_stage = state_.level == 0 && only_weight();
    return;
  }
  finish_path();
}

/// The path is at its end: the last weight once more, with metric and correction renewed and more
/// patience. Those before it only lead there.
void ChannelRun::finish_path() {
  state_.last_stage = true;
  state_.repeated = false;
  if (context_.interim || options_.path.final_tolerance >= options_.path.stage_tolerance)
    conclude();
}

}  // namespace kappamu::inverse
