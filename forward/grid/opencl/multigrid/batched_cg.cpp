#include "forward/grid/opencl/multigrid/batched_cg.h"

#include <algorithm>
#include <cmath>

namespace kappamu::forward {

namespace {

/// The residual is replaced by the true one when it has fallen this much. With 1e-3 the recursion's
/// rounding, as large as the conductances of bright inclusions, outgrew the residual at contrast
/// 1e4: 21 iterations where 1e-2 takes 9.
constexpr double replacement_drop = 1e-2;

}  // namespace

BatchedCg::BatchedCg(device::Context& context, const Format& format, const Hierarchy& hierarchy,
                     Layout layout, int lanes)
    : context_(context),
      hierarchy_(hierarchy),
      steps_(layout == Layout::gpu ? make_flat_steps(context, format, hierarchy, lanes)
                                   : make_stream_steps(context, format, hierarchy, lanes)) {}

BatchedCg::Result BatchedCg::solve(const LaneKernels& kernels, const device::Buffer& b,
                                   const device::Buffer& x, InitialGuess guess,
                                   const SolveOptions& options) {
  const auto lanes = static_cast<std::size_t>(kernels.lanes());
  steps_->begin(guess);
  const CgSteps::Norms first = steps_->true_residual(kernels, b, x);
  Result result;
  result.residual.resize(lanes);
  const auto relative = [&](const LaneScalars& rr) {
    double worst = 0.0;
    for (std::size_t m = 0; m < lanes; ++m) {
      result.residual[m] = first.bb[m] > 0.0 ? std::sqrt(rr[m] / first.bb[m]) : std::sqrt(rr[m]);
      // Comparisons with NaN are false, so a NaN must be carried on by hand.
      if (!(result.residual[m] <= worst)) worst = result.residual[m];
      if (std::isnan(worst)) return worst;
    }
    return worst;
  };

  double worst = relative(first.rr);
  double at_replacement = worst;
  while (worst > options.tolerance && result.iterations < options.max_iterations) {
    worst = relative(steps_->step(kernels));
    ++result.iterations;
    if (worst <= options.tolerance || worst <= replacement_drop * at_replacement ||
        result.iterations == options.max_iterations) {
      const double recursive = worst;
      const std::vector<double> each = result.residual;
      worst = relative(steps_->true_residual(kernels, b, x).rr);
      if (worst <= options.tolerance) break;
      // The recursion believed in progress that did not happen.
      if (worst > 0.5 * at_replacement) {
        result.stagnated = result.iterations < options.max_iterations;
        break;
      }
      // Where directions no longer fit the residual, or one pattern's by far, hidden under the
      // worst of all: start again from the preconditioned one.
      bool lost = worst > 2.0 * recursive;
      for (std::size_t m = 0; m < lanes; ++m) {
        lost = lost || result.residual[m] > std::max(options.tolerance, 10.0 * each[m]);
      }
      if (lost) steps_->restart();
      at_replacement = worst;
    }
  }
  return result;
}

void BatchedCg::apply(const LaneKernels& kernels, const device::Buffer& in,
                      const device::Buffer& out) {
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  context_.launch(kernels.common(), "apply", kernels.rows(s), s.nx, s.ny, s.nz, level.stencils, in,
                  out);
}

}  // namespace kappamu::forward
