// A channel's fit between two weights: grids, correction and regulariser, and how the path
// (regularisation_path.h) is followed.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>

#include "core/numbers/median.h"
#include "inverse/fit/channel_run.h"
#include "inverse/fit/fit_fingerprint.h"

namespace kappamu::inverse {

namespace {

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

GridLevels make_levels(const SurfaceMeasurements& measurements, int channel,
                       const FitOptions& options) {
  const DataOptions& data = options.data;
  const bool unweighted = options.regulariser.kind == RegulariserKind::wang2008;
  return {make_problem(measurements, channel, data.convention, data.model_error),
          data.coarse_model_error, unweighted ? DataWeights::equal : DataWeights::by_variance,
          options.path.max_levels};
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
      levels_(make_levels(measurements, channel, options)) {}

void ChannelRun::open_level() {
  const Problem& problem = levels_[state_.level];
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
    objective_->refresh_correction(levels_.refinement(state_.level), state_.fields);
  } else {
    objective_->value(state_.fields);
  }
  state_.correction = objective_->correction();
  return objective_->chi2_per_value();
}

void ChannelRun::follow_path(StepsEnd end) {
  CoefficientPair begun = std::move(state_.fields);
  state_.fields = basis_->to_fields(state_.optimiser.z);
  // What counts is the χ² of a model corrected here, not where this weight was begun.
  const double minimised = state_.chi2;
  const double renewed = refresh_correction();
  switch (path_.minimum(minimised, renewed, cross_validation(renewed), state_.level)) {
    case NextStep::conclude_as_begun:
      state_.fields = std::move(begun);
      refresh_correction();
      [[fallthrough]];
    case NextStep::conclude:
      return conclude(end);
    case NextStep::minimise_as_begun:
      state_.fields = std::move(begun);
      refresh_correction();
      break;
    case NextStep::minimise:
      break;
    case NextStep::finer_grid_as_begun:
      state_.fields = std::move(begun);
      [[fallthrough]];
    case NextStep::finer_grid:
      refine();
  }
  begin_weight();
}

/// χ²/(1 − γ/N)² per value, N data of which γ unknowns take theirs (Golub, Heath & Wahba 1979); γ
/// by the metric. 0 where there is none.
double ChannelRun::cross_validation(double chi2) const {
  if (options_.solver.coordinates != Coordinates::informed || state_.blocks.empty()) return 0.0;
  const Basis::Determined told = basis_->determined(state_.blocks);
  const double left =
      1.0 - (told.kappa + told.mu) / static_cast<double>(objective_->problem().used());
  return left > 0.0 ? chi2 / (left * left) : std::numeric_limits<double>::infinity();
}

/// The fields go on to the next finer grid.
void ChannelRun::refine() {
  const SolveCount solves = objective_->solves();
  state_.fields = levels_.to_finer(state_.fields, state_.level);
  --state_.level;
  open_level();
  objective_->restore(objective_->correction(), solves);
  state_.optimiser = OptimiserState{};
  path_.refine(refresh_correction(), state_.level);
}

}  // namespace kappamu::inverse
