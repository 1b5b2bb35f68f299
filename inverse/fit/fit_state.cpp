// A fit's state as a checkpoint's bytes, which of them a fit takes, and how it goes on from there.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "inverse/checkpoint/checkpoint.h"
#include "inverse/checkpoint/state_bytes.h"
#include "inverse/defaults.h"
#include "inverse/fit/fit_run.h"
#include "inverse/fit/minimise.h"
#include "inverse/optimise/lateral_modes.h"

namespace kappamu::inverse {

template <class T, class U>
concept Is = std::same_as<std::remove_const_t<T>, U>;

// Contents of a checkpoint, in order. The same lines write and read it.

static void transfer(ByteWriter& out, const Eigen::MatrixXd& block) {
  out(static_cast<std::uint64_t>(block.rows()),
      std::vector<double>(block.data(), block.data() + block.size()));
}
static void transfer(ByteReader& in, Eigen::MatrixXd& block) {
  constexpr std::uint64_t most_rows = std::uint64_t{1} << 31;  // so that their square is a number
  std::uint64_t rows = 0;
  std::vector<double> values;
  in(rows, values);
  if (rows > most_rows || values.size() != rows * rows) {
    throw InputError("is damaged: its arrays contradict each other");
  }
  const auto size = static_cast<Eigen::Index>(rows);
  block = Eigen::Map<const Eigen::MatrixXd>(values.data(), size, size);
}

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

void transfer(auto& bytes, Is<Correction> auto& r) {
  bytes(r.ratio, r.variance, r.pixel_variance, r.slope[0], r.slope[1], r.mean[0], r.mean[1]);
}

void transfer(auto& bytes, Is<LbfgsProducts> auto& p) {
  bytes(p.step_square, p.by_step, p.by_change);
}

void transfer(auto& bytes, Is<OptimiserState> auto& s) {
  bytes(s.z, s.gradient, s.direction, s.previous_gradient, s.value, s.previous_step, s.steps,
        s.changes, s.products);
}

void transfer(auto& bytes, Is<StageState> auto& s) {
  bytes(s.chi2, s.corrected_chi2, s.steps, s.small_decreases, s.again, s.begun.log_kappa,
        s.begun.log_mu, s.blocks, s.scaled_blocks, s.optimiser);
}

void transfer(auto& bytes, Is<FitState> auto& s) {
  bytes.enumerator(s.end, PathEnd::lowest);
  bytes(s.level, s.closer, s.weight, s.last, s.finished, s.last_chi2, s.last_score, s.seconds,
        s.fields.log_kappa, s.fields.log_mu, s.solves, s.correction, s.stage, s.report, s.simpler);
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

std::size_t most_checkpoint_bytes(const SurfaceMeasurements& m, const FitOptions& options) {
  // Two volumes, z and three more of its size, two floats a pair; blocks; r.
  const auto cells = static_cast<double>(m.grid.cells());
  const double depth = m.grid.extent(axis_of(m.lit_face));
  const double bins = std::max({m.grid.nx, m.grid.ny, m.grid.nz}) * 2.0 + 1.0;
  const double doubles = 2.0 * cells * (2.0 + 4.0 + options.solver.optimiser.memory) +
                         2.0 * bins * 4.0 * depth * depth +
                         5.0 * static_cast<double>(m.seen_shape().cells()) * m.patterns;
  constexpr double history_bytes = 64.0 * 1048576.0;  // of a million steps
  return static_cast<std::size_t>(8.0 * doubles + history_bytes);
}

}  // namespace kappamu::inverse
