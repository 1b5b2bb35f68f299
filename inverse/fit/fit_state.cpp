// A fit's state as a checkpoint's bytes, and which states a fit goes on from.
#include <algorithm>
#include <cmath>
#include <concepts>
#include <functional>

#include "core/error.h"
#include "inverse/checkpoint/state_bytes.h"
#include "inverse/fit/fit_run.h"

namespace kappamu::inverse {

template <class T, class U>
concept Is = std::same_as<std::remove_const_t<T>, U>;

// What a checkpoint holds, in this order: the same lines write and read it.

void transfer(auto& bytes, Is<SolveCount> auto& s) {
  bytes(s.forward, s.adjoint, s.refined, s.tangent, s.photons, s.voxel_iterations);
}

void transfer(auto& bytes, Is<ModelTrial> auto& t) {
  bytes.enumerator(t.model, Model::volume);
  bytes(t.level, t.layers, t.chi2_per_value, t.coherent, t.coherent_limit, t.rejected);
}

void transfer(auto& bytes, Is<ModelChoice> auto& choice) {
  bytes.enumerator(choice.model, Model::volume);
  bytes(choice.layers, choice.reason, choice.systematic, choice.systematic_length, choice.trials);
}

void transfer(auto& bytes, Is<Estimate> auto& estimate) {
  bytes(estimate.value, estimate.error);
}

void transfer(auto& bytes, Is<Consistency> auto& c) {
  bytes(c.checked, c.explained, c.other_eta, c.log_scale, c.shift_u, c.shift_v, c.log_scale_limit,
        c.shift_limit, c.solves);
}

void transfer(auto& bytes, Is<StepRecord> auto& r) {
  bytes(r.level, r.step, r.solves, r.weight, r.objective, r.chi2_per_value, r.roughness, r.seconds);
}

void transfer(auto& bytes, Is<FitReport> auto& report) {
  bytes(report.history, report.warnings);
  bytes.enumerator(report.status, FitStatus::ran_out);
  bytes(report.reason, report.homogeneous_kappa, report.homogeneous_mu,
        report.homogeneous_log_residual);
  bytes.enumerator(report.physics, Physics::automatic);
  bytes(report.physics_reason, report.model, report.consistency);
}

void transfer(auto& bytes, Is<LayeredMedium> auto& medium) {
  bytes(medium.first, medium.log_kappa, medium.log_mu);
}

void transfer(auto& bytes, Is<FitState> auto& s) {
  bytes.enumerator(s.end, PathEnd::lowest);
  bytes(s.level, s.closer, s.weight, s.last, s.finished, s.last_chi2, s.last_score, s.seconds,
        s.fields.log_kappa, s.fields.log_mu, s.solves, s.report, s.simpler);
}

std::vector<std::byte> FitState::bytes() const {
  ByteWriter out;
  out(*this);
  return out.bytes();
}

FitState FitState::from(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  FitState state;
  in(state);
  if (!in.at_end()) throw InputError("is damaged: it ends too late");
  return state;
}

std::size_t most_checkpoint_bytes(const SurfaceMeasurements& m) {
  constexpr std::size_t history_bytes = std::size_t{64} << 20U;  // of a million steps
  return 2 * sizeof(double) * m.grid.cells() + history_bytes;
}

namespace {

void require(bool holds) {
  if (!holds) throw InputError("is damaged: it holds impossible values");
}

bool finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

bool in_range(const std::vector<double>& logs, std::size_t size) {
  return logs.size() == size && std::all_of(logs.begin(), logs.end(), [](double x) {
           return std::abs(x) <= max_log_coefficient;
         });
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

}  // namespace

void require_possible(const FitState& state, const GridLevels& levels, const FitOptions& options) {
  const auto is_level = [&](int level) { return level >= 0 && level < levels.count(); };
  require(is_level(state.level));
  require(!state.closer || (state.level == 1 && levels.closer() != nullptr));
  require(state.level == 0 || !(state.last || state.finished));
  require(state.weight >= 0.0 &&
          finite({state.weight, state.last_chi2, state.last_score, state.seconds}));
  const MediumSpace space = levels[state.level].space();
  require(in_range(state.fields.log_kappa, space.cells()) &&
          in_range(state.fields.log_mu, space.cells()));
  require(possible(state.solves));

  const FitReport& report = state.report;
  require(report.physics == options.data.physics ||
          (options.data.physics == Physics::automatic && report.physics != Physics::automatic));
  require(report.homogeneous_kappa > 0.0 && report.homogeneous_mu > 0.0 &&
          finite({report.homogeneous_kappa, report.homogeneous_mu}));
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

}  // namespace kappamu::inverse
