#include "inverse/fit/fit_fingerprint.h"

#include <span>

#include "forward/grid/grid_solver.h"
#include "inverse/optimise/state_bytes.h"

namespace kappamu::inverse {

namespace {

/// Channel `channel` of `m` with the light it was seen under.
void add(Fingerprint& print, const SurfaceMeasurements& m, int channel) {
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
}

}  // namespace

std::uint64_t fingerprint(const SurfaceMeasurements& m, int channel, const FitOptions& o,
                          const FitContext& context) {
  Fingerprint print;
  print.add(channel);
  add(print, m, channel);
  print.add(context.interim);
  print.add(context.continued.has_value());
  if (context.continued) {
    const Continuation& c = *context.continued;
    print.add(std::span<const double>(c.medium.kappa.values()));
    print.add(std::span<const double>(c.medium.mu.values()));
    for (const double x : {c.homogeneous_kappa, c.homogeneous_mu, c.weight}) print.add(x);
  }

  print.add(o.model);
  print.add(o.start ? o.start->kappa : 0.0);
  print.add(o.start ? o.start->mu : 0.0);
  print.add(o.optimiser.method);
  for (const int n : {o.optimiser.memory, o.optimiser.max_backtracks, o.optimiser.newton_iterations,
                      o.stage_steps, o.max_levels, o.metric_probes, o.backend.batch,
                      o.backend.solve.max_iterations}) {
    print.add(n);
  }
  print.add(o.coordinates);
  print.add(o.data_term.loss);
  print.add(o.regulariser.kind);
  for (const double x :
       {o.data_term.huber_threshold, o.data_term.student_freedom, o.regulariser.edge_slope}) {
    print.add(x);
  }
  print.add(o.convention);
  print.add(o.weight.has_value());
  for (const double x : {o.weight.value_or(0.0),
                         o.first_weight,
                         o.last_weight,
                         o.weight_factor,
                         o.restart_steps,
                         o.target_chi2,
                         o.stagnation,
                         o.stage_tolerance,
                         o.final_tolerance,
                         o.model_error.relative,
                         o.model_error.of_maximum,
                         o.coarse_model_error.relative,
                         o.coarse_model_error.of_maximum,
                         o.smooth_length,
                         o.anchor_length,
                         o.optimiser.first_step,
                         o.optimiser.longest_step,
                         o.optimiser.golden_tolerance,
                         o.optimiser.newton_forcing,
                         o.backend.solve.tolerance,
                         o.backend.refined_memory_mb,
                         o.backend.refined_tolerance}) {
    print.add(x);
  }
  print.add(o.correct_grid);
  print.add(o.seed);
  print.add(o.backend.precision);
  print.add(o.backend.device);
  return print.value();
}

std::uint64_t program_fingerprint(const std::string& program, const Backend& backend) {
  Fingerprint print;
  print.add(program);
  print.add(forward::device_identity(backend.device));
  return print.value();
}

}  // namespace kappamu::inverse
