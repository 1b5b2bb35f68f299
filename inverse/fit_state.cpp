#include "inverse/fit_state.h"

#include <utility>

#include "inverse/state_bytes.h"

namespace kappamu::inverse {

namespace {

constexpr std::uint64_t magic = 0x6b6d2d6669742d34ULL;  // "km-fit-4"

void write(ByteWriter& out, const SolveCount& solves) {
  for (const int n : {solves.forward, solves.adjoint, solves.refined, solves.tangent}) out.put(n);
  out.put(solves.voxel_iterations);
}

void read(ByteReader& in, SolveCount& solves) {
  for (int* n : {&solves.forward, &solves.adjoint, &solves.refined, &solves.tangent}) in.get(*n);
  in.get(solves.voxel_iterations);
}

void write(ByteWriter& out, const FitReport& report) {
  out.put<std::uint64_t>(report.history.size());
  for (const StepRecord& r : report.history) {
    for (const int n : {r.level, r.step}) out.put(n);
    write(out, r.solves);
    for (const double x : {r.weight, r.objective, r.chi2_per_datum, r.roughness, r.seconds}) {
      out.put(x);
    }
  }
  out.put<std::uint64_t>(report.warnings.size());
  for (const std::string& w : report.warnings) out.put(w);
  out.put(report.status);
  out.put(report.message);
  for (const double x : {report.homogeneous_kappa, report.homogeneous_mu,
                         report.homogeneous_log_residual, report.chi2_per_datum, report.weight}) {
    out.put(x);
  }
}

void read(ByteReader& in, FitReport& report) {
  std::uint64_t count = 0;
  in.get(count);
  for (std::uint64_t k = 0; k < count; ++k) {
    StepRecord& r = report.history.emplace_back();
    for (int* n : {&r.level, &r.step}) in.get(*n);
    read(in, r.solves);
    for (double* x : {&r.weight, &r.objective, &r.chi2_per_datum, &r.roughness, &r.seconds}) {
      in.get(*x);
    }
  }
  in.get(count);
  for (std::uint64_t k = 0; k < count; ++k) in.get(report.warnings.emplace_back());
  in.get(report.status);
  in.get(report.message);
  for (double* x : {&report.homogeneous_kappa, &report.homogeneous_mu,
                    &report.homogeneous_log_residual, &report.chi2_per_datum, &report.weight}) {
    in.get(*x);
  }
}

}  // namespace

std::vector<std::byte> FitState::bytes(std::uint64_t fingerprint) const {
  ByteWriter out;
  out.put(magic);
  out.put(fingerprint);
  for (const int n : {level, stage_steps, small_decreases}) out.put(n);
  for (const bool b : {in_stage, finished, ran_out, repeated}) out.put(b);
  for (const double x : {last_chi2, seconds, weight, roughness}) out.put(x);
  out.put(fields.log_kappa);
  out.put(fields.log_mu);
  out.put<std::uint64_t>(blocks.size());
  for (const Eigen::MatrixXd& block : blocks) {
    out.put<std::uint64_t>(static_cast<std::uint64_t>(block.rows()));
    out.put(std::vector<double>(block.data(), block.data() + block.size()));
  }
  optimiser.write(out);
  out.put(correction);
  write(out, solves);
  write(out, report);
  return out.bytes();
}

bool FitState::restore(std::span<const std::byte> bytes, std::uint64_t fingerprint) {
  try {
    ByteReader in(bytes);
    std::uint64_t found_magic = 0;
    std::uint64_t found_fingerprint = 0;
    in.get(found_magic);
    in.get(found_fingerprint);
    if (found_magic != magic || found_fingerprint != fingerprint) return false;
    FitState state;
    for (int* n : {&state.level, &state.stage_steps, &state.small_decreases}) in.get(*n);
    for (bool* b : {&state.in_stage, &state.finished, &state.ran_out, &state.repeated}) in.get(*b);
    for (double* x : {&state.last_chi2, &state.seconds, &state.weight, &state.roughness})
      in.get(*x);
    in.get(state.fields.log_kappa);
    in.get(state.fields.log_mu);
    std::uint64_t count = 0;
    in.get(count);
    for (std::uint64_t k = 0; k < count; ++k) {
      std::uint64_t rows = 0;
      std::vector<double> values;
      in.get(rows);
      in.get(values);
      if (values.size() != rows * rows) return false;
      const auto size = static_cast<Eigen::Index>(rows);
      state.blocks.emplace_back(Eigen::Map<const Eigen::MatrixXd>(values.data(), size, size));
    }
    state.optimiser.read(in);
    in.get(state.correction);
    read(in, state.solves);
    read(in, state.report);
    if (!in.at_end()) return false;
    *this = std::move(state);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

std::uint64_t fingerprint(const SurfaceMeasurements& m, int channel, const FitOptions& o) {
  Fingerprint print;
  print.add(channel);
  for (const int n : {m.grid.nx, m.grid.ny, m.grid.nz, m.patterns}) print.add(n);
  for (const double x : {m.grid.voxel_mm, m.eta}) print.add(x);
  print.add(m.lit_face);
  print.add(m.seen_face);
  print.add(m.quantity);
  print.add(m.light);
  print.add(m.sides);
  print.add(std::span<const float>(m.irradiance));
  const std::size_t count = m.seen_shape().cells() * static_cast<std::size_t>(m.patterns);
  const std::size_t first = count * static_cast<std::size_t>(channel);
  print.add(std::span<const float>(m.value).subspan(first, count));
  print.add(std::span<const float>(m.variance).subspan(first, count));
  if (!m.mask.empty()) print.add(std::span<const std::uint8_t>(m.mask).subspan(first, count));

  print.add(o.optimiser.method);
  for (const int n : {o.optimiser.memory, o.optimiser.max_backtracks, o.stage_steps, o.max_levels,
                      o.metric_probes, o.backend.batch, o.backend.solve.max_iterations}) {
    print.add(n);
  }
  print.add(o.coordinates);
  print.add(o.convention);
  print.add(o.weight.has_value());
  for (const double x :
       {o.weight.value_or(0.0), o.first_weight, o.last_weight, o.weight_factor, o.restart_steps,
        o.target_chi2, o.stagnation, o.stage_tolerance, o.model_error.relative,
        o.model_error.of_maximum, o.coarse_model_error.relative, o.coarse_model_error.of_maximum,
        o.smooth_length, o.anchor_length, o.optimiser.first_step, o.optimiser.longest_step,
        o.optimiser.golden_tolerance, o.backend.solve.tolerance, o.backend.refined_memory_mb}) {
    print.add(x);
  }
  print.add(o.correct_grid);
  print.add(o.seed);
  print.add(o.backend.precision);
  print.add(o.backend.device);
  return print.value();
}

}  // namespace kappamu::inverse
