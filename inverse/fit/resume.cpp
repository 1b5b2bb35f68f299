// Whether a checkpoint can be gone on from, and going on from it.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "core/error.h"
#include "inverse/checkpoint/checkpoint.h"
#include "inverse/defaults.h"
#include "inverse/fit/fit_run.h"
#include "inverse/fit/minimise.h"
#include "inverse/optimise/lateral_modes.h"

namespace kappamu::inverse {

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
