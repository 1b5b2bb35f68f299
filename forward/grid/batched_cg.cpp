#include "forward/grid/batched_cg.h"

#include <algorithm>
#include <cmath>

namespace kappamu::forward {

namespace {

/// The residual is replaced by the true one when it has fallen this much: float's own rounding is
/// then still four decades below it.
constexpr double replacement_drop = 1e-3;

}  // namespace

BatchedCg::BatchedCg(device::Context& context, const Format& format, const Hierarchy& hierarchy,
                     Layout layout, int lanes)
    : context_(context),
      hierarchy_(hierarchy),
      sums_(context, format, lanes),
      steps_(layout == Layout::gpu ? make_flat_steps(context, format, hierarchy, lanes)
                                   : make_stream_steps(context, format, hierarchy, lanes)),
      cells_(hierarchy.finest().shape.cells()) {
  const auto l = static_cast<std::size_t>(lanes);
  for (device::Buffer* field : {&r_, &d_}) {
    *field = context.allocate(cells_ * l * format.real_bytes());
  }
  const std::size_t sums = row_sums(hierarchy.finest().shape, layout);
  for (device::Buffer* partial : {&partial_rr_, &partial_bb_}) {
    *partial = context.allocate(sums * l * format.accu_bytes());
  }
  for (device::Buffer* scalar : {&rr_, &bb_}) *scalar = context.allocate(l * format.accu_bytes());
}

BatchedCg::Result BatchedCg::solve(const LaneKernels& kernels, const device::Buffer& b,
                                   const device::Buffer& x, const SolveOptions& options) {
  const auto lanes = static_cast<std::size_t>(kernels.lanes());
  LaneScalars bb;
  Result result;
  result.residual.resize(lanes);
  const auto relative = [&](const LaneScalars& rr) {
    double worst = 0.0;
    for (std::size_t m = 0; m < lanes; ++m) {
      result.residual[m] = bb[m] > 0.0 ? std::sqrt(rr[m] / bb[m]) : std::sqrt(rr[m]);
      // Comparisons with NaN are false, so a NaN must be carried on by hand.
      if (!(result.residual[m] <= worst)) worst = result.residual[m];
      if (std::isnan(worst)) return worst;
    }
    return worst;
  };

  const LaneScalars first = true_residual(kernels, b, x, false, &bb);
  double worst = relative(first);
  double at_replacement = worst;
  // Up to the first replacement steps go to x itself, from then on to the correction d.
  bool has_correction = false, first_correction = false;
  steps_->restart();
  while (worst > options.tolerance && result.iterations < options.max_iterations) {
    worst = relative(steps_->step(kernels, r_, has_correction ? d_ : x, first_correction));
    first_correction = false;
    ++result.iterations;
    if (worst <= options.tolerance || worst <= replacement_drop * at_replacement ||
        result.iterations == options.max_iterations) {
      const double recursive = worst;
      worst = relative(true_residual(kernels, b, x, has_correction, nullptr));
      if (worst <= options.tolerance) break;
      // The recursion believed in progress that did not happen.
      if (worst > 0.5 * at_replacement) {
        result.stagnated = result.iterations < options.max_iterations;
        break;
      }
      if (has_correction) {
        launch_over_cells(kernels, "renormalise", x, d_);
      } else {
        has_correction = first_correction = true;
      }
      // Where directions no longer fit the residual: start again from the preconditioned one.
      if (worst > 2.0 * recursive) steps_->restart();
      at_replacement = worst;
    }
  }
  if (has_correction && !first_correction) launch_over_cells(kernels, "add", d_, x);
  return result;
}

void BatchedCg::apply(const LaneKernels& kernels, const device::Buffer& in,
                      const device::Buffer& out) {
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  context_.launch(kernels.level_operator(), "apply_dot", kernels.rows(s), s.nx, s.ny, s.nz,
                  level.gx, level.gy, level.gz, level.sink, in, out, partial_rr_);
}

LaneScalars BatchedCg::true_residual(const LaneKernels& kernels, const device::Buffer& b,
                                     const device::Buffer& x, bool with_correction,
                                     LaneScalars* scale) {
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  context_.launch(kernels.level_operator(), "residual_accurate", kernels.rows(s), s.nx, s.ny, s.nz,
                  level.gx, level.gy, level.gz, level.sink, int{with_correction}, x, d_, b, r_,
                  partial_rr_, partial_bb_);
  const std::size_t count = row_sums(s, kernels.layout());
  if (scale != nullptr) {
    sums_.add_up(kernels, partial_bb_, count, bb_);
    *scale = sums_.read(kernels, bb_);
  }
  sums_.add_up(kernels, partial_rr_, count, rr_);
  return sums_.read(kernels, rr_);
}

void BatchedCg::launch_over_cells(const LaneKernels& kernels, const char* kernel,
                                  const device::Buffer& first, const device::Buffer& second) {
  const int runs = kernels.runs(cells_);
  context_.launch(kernels.vectors(), kernel, kernels.items(static_cast<std::size_t>(runs)),
                  static_cast<int>(cells_), runs, first, second);
}

}  // namespace kappamu::forward
