// A fit that goes on from a checkpoint: which states it takes, and how it becomes again what it was
// when it was killed.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "core/error.h"
#include "inverse/checkpoint/checkpoint.h"
#include "inverse/fit/channel_run.h"
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

bool has(const CoefficientPair& fields, std::size_t cells) {
  const auto in_range = [](double x) { return std::abs(x) <= max_log_coefficient; };
  return has(fields.log_kappa, cells) && has(fields.log_mu, cells) &&
         std::all_of(fields.log_kappa.begin(), fields.log_kappa.end(), in_range) &&
         std::all_of(fields.log_mu.begin(), fields.log_mu.end(), in_range);
}

/// With z of `size` and at most `pairs` of L-BFGS.
void require_possible(const OptimiserState& s, std::size_t size, int pairs) {
  require(has(s.z, size) && has(s.gradient, size));
  for (const Vector* v : {&s.direction, &s.previous_gradient}) {
    require(v->empty() || has(*v, size));
  }
  require(s.direction.empty() == s.previous_gradient.empty());
  require(std::isfinite(s.value) && std::isfinite(s.previous_step));
  require(s.steps.size() <= static_cast<std::size_t>(pairs) && s.changes.size() == s.steps.size() &&
          s.products.size() == s.steps.size());
  for (const auto* list : {&s.steps, &s.changes}) {
    for (const std::vector<float>& v : *list) require(has(v, size));
  }
}

void require_possible(const LayeredMedium& medium, int depth) {
  const std::vector<int>& first = medium.first;
  require(!first.empty() && first.front() == 0 && first.back() < depth);
  require(std::adjacent_find(first.begin(), first.end(), std::greater_equal<>()) == first.end());
  require(has({medium.log_kappa, medium.log_mu}, first.size()));
}

void require_possible(const SolveCount& s) {
  for (const int n : {s.forward, s.adjoint, s.refined, s.tangent}) require(n >= 0);
  require(std::isfinite(s.photons) && std::isfinite(s.voxel_iterations));
}

}  // namespace

/// Throws InputError, the end of a sentence "A checkpoint ...", unless the fit can go on from
/// `state` without reading or writing beyond an array. A checksum is no guard against intent.
void ChannelRun::require_possible(const FitState& state) const {
  using inverse::require_possible;
  const int levels = grid_.levels().count();
  require(state.level >= 0 && state.level < levels);
  require(!state.closer || (state.level == 1 && grid_.levels().closer()));
  const Problem& problem = grid_.levels()[state.level];
  const GridShape& shape = problem.setup.shape;
  const int axis = axis_of(problem.setup.lit_face);

  // It is saved within a weight or at the end.
  const bool finished = state.path.phase == FitPhase::finished;
  const bool descends =
      state.path.phase == FitPhase::descending || state.path.phase == FitPhase::descending_again;
  require(descends || state.level == 0);
  require(state.stage_steps >= 0 && state.stage_steps <= options_.path.stage_steps);
  require(state.small_decreases >= 0 && state.small_decreases <= 2);
  for (const double x : {state.path.last_chi2, state.path.weight, state.seconds, state.roughness,
                         state.chi2, state.corrected_chi2}) {
    require(std::isfinite(x));
  }
  require(has(state.fields, shape.cells()));
  const Correction& correction = state.correction;
  const std::size_t noisy = state.report.physics == Physics::transport ? problem.data.size() : 0;
  require(has(correction.ratio, problem.data.size()) && has(correction.variance, noisy) &&
          has(correction.pixel_variance, noisy));
  for (const Vector& slope : correction.slope) require(slope.empty() || has(slope, noisy));
  require(std::isfinite(correction.mean[0]) && std::isfinite(correction.mean[1]));
  for (const Vector* v : {&correction.variance, &correction.pixel_variance}) {
    require(std::all_of(v->begin(), v->end(), [](double x) { return x >= 0.0; }));
  }
  require(
      state.report.physics == options_.data.physics ||
      (options_.data.physics == Physics::automatic && state.report.physics != Physics::automatic));
  require_possible(state.solves);

  const FitReport& report = state.report;
  require(report.homogeneous_kappa > 0.0 && report.homogeneous_mu > 0.0);
  require(finite(Vector{report.homogeneous_kappa, report.homogeneous_mu, report.chi2_per_value,
                        report.weight}));
  require(!report.history.empty());
  for (const StepRecord& r : report.history) {
    require(r.level >= 0 && r.level < levels);
    require_possible(r.solves);
  }
  const int depth = grid_.levels()[0].setup.shape.extent(axis);
  require(report.model.layers >= 0 && report.model.layers <= depth);
  for (const ModelTrial& t : report.model.trials) {
    require(t.level >= 0 && t.level < levels && t.layers >= 0 && t.layers <= depth);
  }
  for (const LayeredMedium& medium : state.simpler) require_possible(medium, depth);

  require(state.path.weight >= 0.0);
  if (finished) {
    require(state.optimiser.z.empty() && state.blocks.empty() && state.scaled_blocks.empty());
    return;
  }
  require_possible(state.optimiser, 2 * shape.cells(), options_.solver.optimiser.memory);
  const bool informed = options_.solver.coordinates == Coordinates::informed;
  const LateralModes modes(problem.space());
  for (const LateralBlocks* blocks : {&state.blocks, &state.scaled_blocks}) {
    require(blocks->size() == (informed ? static_cast<std::size_t>(modes.bins()) : 0));
    for (const Eigen::MatrixXd& block : *blocks) {
      require(block.rows() == modes.rows() && block.allFinite() &&
              block.llt().info() == Eigen::Success);
    }
  }
}

/// As it was when `state` was saved, to the same bits and counts. Throws InputError as
/// require_possible() does where no metric can be made of it.
void ChannelRun::become(FitState state) {
  require_possible(state);
  state_ = std::move(state);
  set_physics(state_.report.physics);
  open(state_.level, state_.closer);
  grid_.objective().restore(state_.correction, state_.solves);
  // What was solved last is solved anew and not counted: what comes next finds it at hand.
  if (state_.path.phase != FitPhase::finished) {
    try {
      set_basis();
    } catch (const InternalError&) {
      throw InputError(impossible);
    }
    function_->value(state_.optimiser.z);
  } else if (state_.report.model.model == Model::volume) {
    grid_.objective().value(state_.fields);
  }
  grid_.objective().restore(std::move(state_.correction), state_.solves);
}

/// From the newest checkpoint that can be used; false where there is none.
bool ChannelRun::resume() {
  std::vector<std::string> unusable;
  bool resumed = false;
  while (!resumed && checkpoint_.load) {
    const std::optional<std::vector<std::byte>> bytes = checkpoint_.load();
    if (!bytes) break;
    try {
      become(FitState::from(unseal(*bytes, origin_)));
      resumed = true;
    } catch (const InputError& error) {
      unusable.emplace_back(error.what());
    }
  }
  if (!resumed) {
    state_ = FitState{};
    grid_.set_photons(std::nullopt);
  }
  for (const std::string& sentence : state_.report.warnings) tell(sentence);
  for (const std::string& reason : unusable) {
    warn("A checkpoint " + reason +
         (resumed ? "; the fit goes on from the one before." : "; the fit starts anew."));
  }
  return resumed;
}

}  // namespace kappamu::inverse
