#include "inverse/fit/minimise.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "core/error.h"
#include "inverse/checkpoint/checkpoint.h"
#include "inverse/defaults.h"
#include "inverse/fit/fit_run.h"
#include "inverse/optimise/lateral_hessian.h"
#include "inverse/optimise/lateral_modes.h"

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

void record(FitRun& run, const Stage& stage, const CoefficientPair& fields) {
  run.record({.step = stage.steps,
              .objective = stage.optimiser.value,
              .chi2_per_value = stage.chi2,
              .roughness = stage.function->last_roughness()},
             fields);
}

/// With r renewed, but with the metric and what was learned of the Hessian.
void update_correction(FitRun& run, Stage& stage) {
  stage.optimiser.value = stage.function->value(stage.optimiser.z);
  stage.optimiser.gradient = stage.function->gradient();
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

void minimise(FitRun& run, Stage& stage) {
  const double least = tolerance(run.options.path, run.state.last);
  const double shared = shared_error(run.grid.problem());
  const auto found = [&] { return stage.small_decreases >= defaults::few_decreases; };
  const auto out_of_steps = [&] { return stage.steps >= run.options.path.stage_steps; };
  while (!found() && !out_of_steps()) {
    const double before = stage.optimiser.value;
    if (step(*stage.function, stage.optimiser, run.options.solver.optimiser) ==
        StepOutcome::stalled) {
      break;
    }
    ++stage.steps;
    stage.chi2 = run.grid.objective().chi2_per_value();
    const double after = stage.optimiser.value;
    const bool small = before - after < std::max(least * after, shared);
    stage.small_decreases = small ? stage.small_decreases + 1 : 0;
    const CoefficientPair& fields = stage.function->here();
    record(run, stage, fields);
    if (correction_is_outdated(run, stage)) {
      run.renew_correction(fields);
      update_correction(run, stage);
    }
    if (run.since_save.seconds() >= run.checkpoint.interval_seconds) run.save(stage);
  }
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
  set_function(run, stage);
  stage.optimiser.z = stage.function->coordinates(stage.begun);
  restart(*stage.function, stage.optimiser, [&](Vector& step, Vector& change) {
    stage.function->adopt(*function_before, step, change);
  });
  if (!std::isfinite(stage.optimiser.value)) {
    throw InputError(run.stage_name + ": the diffusion solver fails at the starting volume");
  }
  stage.corrected_chi2 = stage.chi2 = objective.chi2_per_value();
  stage.steps = 0;
  stage.small_decreases = 0;
  record(run, stage, stage.begun);
  run.save(stage);
}

void repeat_weight(FitRun& run, Stage& stage) {
  update_correction(run, stage);
  stage.steps = 0;
  record(run, stage, stage.function->here());
  run.save(stage);
}

void restore_weight(FitRun& run, Stage& stage, StageState saved) {
  static_cast<StageState&>(stage) = std::move(saved);
  set_function(run, stage);
  stage.function->value(stage.optimiser.z);  // what the next step finds solved
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

namespace {

constexpr const char* impossible = "is damaged: it holds impossible values";

void require(bool holds) {
  if (!holds) throw InputError(impossible);
}

template <class Values>
bool finite(const Values& values) {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

template <class Values>
bool has(const Values& values, std::size_t size) {
  return values.size() == size && finite(values);
}

bool in_range(const std::vector<double>& logs, std::size_t size) {
  return logs.size() == size && std::all_of(logs.begin(), logs.end(), [](double x) {
           return std::abs(x) <= max_log_coefficient;
         });
}

bool in_range(const CoefficientPair& fields, std::size_t cells) {
  return in_range(fields.log_kappa, cells) && in_range(fields.log_mu, cells);
}

bool possible(const SolveCount& s) {
  return std::min({s.forward, s.adjoint, s.refined, s.tangent}) >= 0 && std::isfinite(s.photons) &&
         std::isfinite(s.voxel_iterations);
}

bool possible(const LayeredMedium& medium, int depth) {
  const std::vector<int>& first = medium.first;
  return !first.empty() && first.front() == 0 && first.back() < depth &&
         std::adjacent_find(first.begin(), first.end(), std::greater_equal<>()) == first.end() &&
         in_range(medium.log_kappa, first.size()) && in_range(medium.log_mu, first.size());
}

/// r of so many `data`, with noise of its own where it is by photons.
bool possible(const Correction& r, std::size_t data, bool by_photons) {
  const std::size_t noisy = by_photons ? data : 0;
  const auto is_variance = [&](const Vector& v) {
    return has(v, noisy) && std::all_of(v.begin(), v.end(), [](double x) { return x >= 0.0; });
  };
  return has(r.ratio, data) && is_variance(r.variance) && is_variance(r.pixel_variance) &&
         std::all_of(r.slope.begin(), r.slope.end(),
                     [&](const Vector& v) { return v.empty() || has(v, noisy); }) &&
         finite(r.mean);
}

bool possible(const std::vector<LbfgsProducts>& products, std::size_t pairs) {
  bool good = products.size() <= pairs;
  for (std::size_t k = 0; k < products.size(); ++k) {
    const LbfgsProducts& p = products[k];
    good = good && has(p.by_step, k + 1) && has(p.by_change, k + 1) && std::isfinite(p.step_square);
  }
  return good;
}

/// With z of `size` and at most `pairs` of L-BFGS.
bool possible(const OptimiserState& s, std::size_t size, int pairs) {
  const auto fits = [&](const auto& v) { return has(v, size); };
  return fits(s.z) && fits(s.gradient) && std::isfinite(s.value) &&
         std::isfinite(s.previous_step) && (s.direction.empty() || fits(s.direction)) &&
         s.previous_gradient.size() == s.direction.size() && finite(s.previous_gradient) &&
         s.steps.size() <= static_cast<std::size_t>(pairs) && s.changes.size() == s.steps.size() &&
         possible(s.products, s.steps.size()) &&
         std::all_of(s.steps.begin(), s.steps.end(), fits) &&
         std::all_of(s.changes.begin(), s.changes.end(), fits);
}

bool possible(const StageState& s, const MediumSpace& space, const FitOptions& options) {
  const LateralModes modes(space);
  const bool informed = options.solver.coordinates == Coordinates::informed;
  const std::size_t bins = informed ? static_cast<std::size_t>(modes.bins()) : 0;
  const auto fit = [&](const LateralBlocks& blocks) {
    return blocks.size() == bins &&
           std::all_of(blocks.begin(), blocks.end(), [&](const Eigen::MatrixXd& block) {
             return block.rows() == modes.rows() && block.allFinite() &&
                    block.llt().info() == Eigen::Success;
           });
  };
  return s.steps >= 0 && s.steps <= options.path.stage_steps && s.small_decreases >= 0 &&
         s.small_decreases <= defaults::few_decreases && std::isfinite(s.chi2) &&
         std::isfinite(s.corrected_chi2) && in_range(s.begun, space.cells()) &&
         possible(s.optimiser, 2 * space.cells(), options.solver.optimiser.memory) &&
         fit(s.blocks) && fit(s.scaled_blocks);
}

/// Throws InputError, the end of a sentence "A checkpoint ...", unless a fit by `options` on these
/// grids can go on from `state` without reading or writing beyond an array. A checksum is no guard
/// against intent.
void require_possible(const FitState& state, const GridLevels& levels, const FitOptions& options) {
  const auto is_level = [&](int level) { return level >= 0 && level < levels.count(); };
  require(is_level(state.level));
  require(!state.closer || (state.level == 1 && levels.closer() != nullptr));
  require(state.level == 0 || !(state.last || state.finished));
  require(state.weight >= 0.0 &&
          finite(Vector{state.weight, state.last_chi2, state.last_score, state.seconds}));
  const Problem& problem = levels[state.level];
  const MediumSpace space = problem.space();
  require(in_range(state.fields, space.cells()));
  require(possible(state.solves));
  const FitReport& report = state.report;
  require(possible(state.correction, problem.data.size(), report.physics == Physics::transport));
  require(state.finished || possible(state.stage, space, options));

  require(report.physics == options.data.physics ||
          (options.data.physics == Physics::automatic && report.physics != Physics::automatic));
  require(report.homogeneous_kappa > 0.0 && report.homogeneous_mu > 0.0 &&
          finite(Vector{report.homogeneous_kappa, report.homogeneous_mu}));
  require(!report.history.empty());
  for (const StepRecord& r : report.history) require(is_level(r.level) && possible(r.solves));
  const int depth = levels[0].space().depth();
  const auto is_number_of_layers = [&](int layers) { return layers >= 0 && layers <= depth; };
  require(is_number_of_layers(report.model.layers));
  for (const ModelTrial& t : report.model.trials) {
    require(is_level(t.level) && is_number_of_layers(t.layers));
  }
  for (const LayeredMedium& medium : state.simpler) require(possible(medium, depth));
}

/// As it was when `state` was saved. Throws InputError as require_possible() does.
void become(FitRun& run, Stage& stage, FitState state) {
  require_possible(state, run.grid.levels(), run.options);
  run.state = std::move(state);
  run.set_physics(run.state.report.physics);
  run.open(run.state.level, run.state.closer);
  Objective& objective = run.grid.objective();
  objective.restore(run.state.correction, run.state.solves);
  // The last solve is repeated without being counted, because the next step needs it.
  if (run.state.finished) {
    objective.value(run.state.fields);
  } else {
    try {
      restore_weight(run, stage, std::exchange(run.state.stage, {}));
    } catch (const InternalError&) {
      throw InputError(impossible);
    }
  }
  objective.restore(std::exchange(run.state.correction, {}), run.state.solves);
}

}  // namespace

bool resume(FitRun& run, Stage& stage) {
  std::vector<std::string> unusable;
  bool resumed = false;
  while (!resumed && run.checkpoint.load) {
    const std::optional<std::vector<std::byte>> bytes = run.checkpoint.load();
    if (!bytes) break;
    try {
      become(run, stage, FitState::from(unseal(*bytes, run.origin)));
      resumed = true;
    } catch (const InputError& error) {
      unusable.emplace_back(error.what());
    }
  }
  if (!resumed) {
    run.state = FitState{};
    run.grid.set_photons(std::nullopt);
    stage = Stage{};
  }
  for (const std::string& sentence : run.state.report.warnings) {
    run.progress.warn(run.stage_name + ": " + sentence);
  }
  for (const std::string& reason : unusable) {
    run.warn("A checkpoint " + reason +
             (resumed ? "; the fit goes on from the one before." : "; the fit starts anew."));
  }
  return resumed;
}

}  // namespace kappamu::inverse
