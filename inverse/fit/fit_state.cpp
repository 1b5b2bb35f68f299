#include "inverse/fit/fit_state.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "inverse/optimise/state_bytes.h"

namespace kappamu::inverse {

namespace {

/// Of a block: so that their square is a number.
constexpr std::uint64_t most_rows = std::uint64_t{1} << 31;

void write(ByteWriter& out, const SolveCount& solves) {
  for (const int n : {solves.forward, solves.adjoint, solves.refined, solves.tangent}) out.put(n);
  for (const double x : {solves.photons, solves.voxel_iterations}) out.put(x);
}

void read(ByteReader& in, SolveCount& solves) {
  for (int* n : {&solves.forward, &solves.adjoint, &solves.refined, &solves.tangent}) in.get(*n);
  for (double* x : {&solves.photons, &solves.voxel_iterations}) in.get(*x);
}

void write(ByteWriter& out, const ModelChoice& choice) {
  out.put(choice.model);
  out.put(choice.layers);
  out.put(choice.reason);
  for (const double x : {choice.systematic, choice.systematic_length}) out.put(x);
  out.put<std::uint64_t>(choice.trials.size());
  for (const ModelTrial& t : choice.trials) {
    out.put(t.model);
    for (const int n : {t.level, t.layers}) out.put(n);
    for (const double x : {t.chi2_per_value, t.coherent, t.coherent_limit}) out.put(x);
    out.put(t.rejected);
  }
}

void read(ByteReader& in, ModelChoice& choice) {
  in.get(choice.model, Model::volume);
  in.get(choice.layers);
  in.get(choice.reason);
  for (double* x : {&choice.systematic, &choice.systematic_length}) in.get(*x);
  std::uint64_t count = 0;
  in.get(count);
  for (std::uint64_t k = 0; k < count; ++k) {
    ModelTrial& t = choice.trials.emplace_back();
    in.get(t.model, Model::volume);
    for (int* n : {&t.level, &t.layers}) in.get(*n);
    for (double* x : {&t.chi2_per_value, &t.coherent, &t.coherent_limit}) in.get(*x);
    in.get(t.rejected);
  }
}

void write(ByteWriter& out, const Consistency& c) {
  for (const bool b : {c.checked, c.explained, c.other_eta.has_value()}) out.put(b);
  for (const Estimate& e : {c.log_scale, c.shift_u, c.shift_v}) {
    out.put(e.value);
    out.put(e.error);
  }
  for (const double x : {c.log_scale_limit, c.shift_limit, c.other_eta.value_or(0.0)}) out.put(x);
  write(out, c.solves);
}

void read(ByteReader& in, Consistency& c) {
  bool has_eta = false;
  double eta = 0.0;
  for (bool* b : {&c.checked, &c.explained, &has_eta}) in.get(*b);
  for (Estimate* e : {&c.log_scale, &c.shift_u, &c.shift_v}) {
    in.get(e->value);
    in.get(e->error);
  }
  for (double* x : {&c.log_scale_limit, &c.shift_limit, &eta}) in.get(*x);
  if (has_eta) c.other_eta = eta;
  read(in, c.solves);
}

void write(ByteWriter& out, const FitReport& report) {
  out.put<std::uint64_t>(report.history.size());
  for (const StepRecord& r : report.history) {
    for (const int n : {r.level, r.step}) out.put(n);
    write(out, r.solves);
    for (const double x : {r.weight, r.objective, r.chi2_per_value, r.roughness, r.seconds}) {
      out.put(x);
    }
  }
  out.put<std::uint64_t>(report.warnings.size());
  for (const std::string& w : report.warnings) out.put(w);
  out.put(report.status);
  out.put(report.reason);
  for (const double x : {report.homogeneous_kappa, report.homogeneous_mu,
                         report.homogeneous_log_residual, report.chi2_per_value, report.weight}) {
    out.put(x);
  }
  out.put(report.physics);
  out.put(report.physics_reason);
  write(out, report.model);
  write(out, report.consistency);
}

void read(ByteReader& in, FitReport& report) {
  std::uint64_t count = 0;
  in.get(count);
  for (std::uint64_t k = 0; k < count; ++k) {
    StepRecord& r = report.history.emplace_back();
    for (int* n : {&r.level, &r.step}) in.get(*n);
    read(in, r.solves);
    for (double* x : {&r.weight, &r.objective, &r.chi2_per_value, &r.roughness, &r.seconds}) {
      in.get(*x);
    }
  }
  in.get(count);
  for (std::uint64_t k = 0; k < count; ++k) in.get(report.warnings.emplace_back());
  in.get(report.status, FitStatus::ran_out);
  in.get(report.reason);
  for (double* x : {&report.homogeneous_kappa, &report.homogeneous_mu,
                    &report.homogeneous_log_residual, &report.chi2_per_value, &report.weight}) {
    in.get(*x);
  }
  in.get(report.physics, Physics::automatic);
  in.get(report.physics_reason);
  read(in, report.model);
  read(in, report.consistency);
}

}  // namespace

std::vector<std::byte> FitState::bytes() const {
  ByteWriter out;
  for (const int n : {level, stage_steps, small_decreases}) out.put(n);
  out.put(path.phase);
  for (const double x : {path.weight, path.begun_chi2, path.last_chi2, path.last_score}) out.put(x);
  for (const double x : {seconds, roughness, chi2}) out.put(x);
  out.put(fields.log_kappa);
  out.put(fields.log_mu);
  out.put<std::uint64_t>(blocks.size());
  for (const Eigen::MatrixXd& block : blocks) {
    out.put<std::uint64_t>(static_cast<std::uint64_t>(block.rows()));
    out.put(std::vector<double>(block.data(), block.data() + block.size()));
  }
  optimiser.write(out);
  for (const Vector* v : {&correction.ratio, &correction.variance, &correction.pixel_variance}) {
    out.put(*v);
  }
  write(out, solves);
  write(out, report);
  out.put<std::uint64_t>(simpler.size());
  for (const LayeredMedium& medium : simpler) {
    out.put(medium.first);
    out.put(medium.log_kappa);
    out.put(medium.log_mu);
  }
  return out.bytes();
}

FitState FitState::from(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  FitState state;
  for (int* n : {&state.level, &state.stage_steps, &state.small_decreases}) in.get(*n);
  PathPosition& path = state.path;
  in.get(path.phase, FitPhase::finished);
  for (double* x : {&path.weight, &path.begun_chi2, &path.last_chi2, &path.last_score}) in.get(*x);
  for (double* x : {&state.seconds, &state.roughness, &state.chi2}) in.get(*x);
  in.get(state.fields.log_kappa);
  in.get(state.fields.log_mu);
  std::uint64_t count = 0;
  in.get(count);
  for (std::uint64_t k = 0; k < count; ++k) {
    std::uint64_t rows = 0;
    std::vector<double> values;
    in.get(rows);
    in.get(values);
    if (rows > most_rows || values.size() != rows * rows) {
      throw InputError("is damaged: its arrays contradict each other");
    }
    const auto size = static_cast<Eigen::Index>(rows);
    state.blocks.emplace_back(Eigen::Map<const Eigen::MatrixXd>(values.data(), size, size));
  }
  state.optimiser.read(in);
  Correction& r = state.correction;
  for (Vector* v : {&r.ratio, &r.variance, &r.pixel_variance}) in.get(*v);
  read(in, state.solves);
  read(in, state.report);
  in.get(count);
  for (std::uint64_t k = 0; k < count; ++k) {
    LayeredMedium& medium = state.simpler.emplace_back();
    in.get(medium.first);
    in.get(medium.log_kappa);
    in.get(medium.log_mu);
  }
  if (!in.at_end()) throw InputError("is damaged: it ends too late");
  return state;
}

std::size_t most_checkpoint_bytes(const SurfaceMeasurements& m, const FitOptions& options) {
  // Fields, z and three more of its size; two floats a pair; blocks; r.
  const auto cells = static_cast<double>(m.grid.cells());
  const double depth = m.grid.extent(axis_of(m.lit_face));
  const double bins = std::max({m.grid.nx, m.grid.ny, m.grid.nz}) * 2.0 + 1.0;
  const double doubles = 2.0 * cells * (1.0 + 4.0 + options.solver.optimiser.memory + 1.0) +
                         bins * 4.0 * depth * depth +
                         3.0 * static_cast<double>(m.seen_shape().cells()) * m.patterns;
  constexpr double history_bytes = 64.0 * 1048576.0;  // of a million steps
  return static_cast<std::size_t>(8.0 * doubles + history_bytes);
}

}  // namespace kappamu::inverse
