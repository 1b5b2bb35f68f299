#include "forward/grid/batched_cg.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kappamu::forward {

namespace {

/// The residual is replaced by the true one when it has fallen this much: float's own rounding is
/// then still four decades below it.
constexpr double replacement_drop = 1e-3;
constexpr std::size_t most_stripes = 64;
/// Up to this many partial sums are added in one go.
constexpr std::size_t few_partials = 512;

}  // namespace

BatchedCg::BatchedCg(device::Context& context, const Format& format, const Hierarchy& hierarchy,
                     int lanes)
    : context_(context),
      format_(format),
      hierarchy_(hierarchy),
      multigrid_(context, format, hierarchy, lanes),
      cells_(hierarchy.finest().shape.cells()) {
  const auto l = static_cast<std::size_t>(lanes);
  for (device::Buffer* field : {&r_, &z_, &p_, &q_}) {
    *field = context.allocate(cells_ * l * format.real_bytes());
  }
  total_ = context.allocate(cells_ * l * format.accu_bytes());
  // At most one partial sum per segment of a row or per run; both are fewer than cells.
  partial_ = context.allocate(cells_ * l * format.accu_bytes());
  stripes_ = context.allocate(most_stripes * l * format.accu_bytes());
  for (device::Buffer* scalar : {&rz_[0], &rz_[1], &pq_, &rr_}) {
    *scalar = context.allocate(l * format.accu_bytes());
  }
}

BatchedCg::Result BatchedCg::solve(const LaneKernels& kernels, const device::Buffer& b,
                                   const device::Buffer& x, const SolveOptions& options) {
  const auto lanes = static_cast<std::size_t>(kernels.lanes());
  const std::size_t scalar_bytes = lanes * format_.accu_bytes();
  const int cells = static_cast<int>(cells_);
  const int runs = kernels.runs(cells_);
  const device::Range run_items = kernels.items(static_cast<std::size_t>(runs));

  dot(kernels, b, b, rr_);
  const Scalars bb = read_scalars(kernels, rr_);
  Result result;
  result.residual.resize(lanes);
  const auto relative = [&](const Scalars& rr) {
    double worst = 0.0;
    for (std::size_t m = 0; m < lanes; ++m) {
      result.residual[m] = bb[m] > 0.0 ? std::sqrt(rr[m] / bb[m]) : std::sqrt(rr[m]);
      // Comparisons with NaN are false, so a NaN must be carried on by hand.
      if (!(result.residual[m] <= worst)) worst = result.residual[m];
      if (std::isnan(worst)) return worst;
    }
    return worst;
  };

  double worst = relative(replace_residual(kernels, b, x, true));
  double at_replacement = worst;
  context_.zero(p_, cells_ * lanes * format_.real_bytes());
  context_.zero(rz_[1], scalar_bytes);
  int now = 0;
  while (worst > options.tolerance && result.iterations < options.max_iterations) {
    multigrid_.precondition(kernels, r_, z_, q_);
    dot(kernels, r_, z_, rz_[now]);
    context_.launch(kernels.vectors(), "update_direction", run_items, cells, runs, rz_[now],
                    rz_[1 - now], z_, p_);
    apply_dot(kernels, p_, q_, pq_);
    context_.launch(kernels.vectors(), "update_solution", run_items, cells, runs, rz_[now], pq_, p_,
                    q_, x, r_, partial_);
    sum_partial(kernels, static_cast<std::size_t>(runs), rr_);
    now = 1 - now;
    ++result.iterations;

    worst = relative(read_scalars(kernels, rr_));
    if (worst <= options.tolerance || worst <= replacement_drop * at_replacement ||
        result.iterations == options.max_iterations) {
      const double recursive = worst;
      worst = relative(replace_residual(kernels, b, x, false));
      if (worst <= options.tolerance) break;
      // The recursion believed in progress that did not happen.
      if (worst > 0.5 * at_replacement) {
        result.stagnated = result.iterations < options.max_iterations;
        break;
      }
      if (worst > 2.0 * recursive) {
        // Directions no longer fit the residual: start again from the preconditioned one.
        context_.zero(rz_[1 - now], scalar_bytes);
      }
      at_replacement = worst;
    }
  }
  context_.launch(kernels.vectors(), "store_solution", run_items, cells, runs, total_, x);
  return result;
}

void BatchedCg::apply(const LaneKernels& kernels, const device::Buffer& in,
                      const device::Buffer& out) {
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  context_.launch(kernels.level_operator(), "apply_dot", kernels.rows(s), s.nx, s.ny, s.nz,
                  level.gx, level.gy, level.gz, level.sink, in, out, partial_);
}

void BatchedCg::apply_dot(const LaneKernels& kernels, const device::Buffer& in,
                          const device::Buffer& out, const device::Buffer& scalar) {
  apply(kernels, in, out);
  const GridShape& s = hierarchy_.finest().shape;
  sum_partial(
      kernels,
      s.cells() / static_cast<std::size_t>(s.nx) * static_cast<std::size_t>(kernels.segments(s)),
      scalar);
}

void BatchedCg::dot(const LaneKernels& kernels, const device::Buffer& a, const device::Buffer& b,
                    const device::Buffer& scalar) {
  const int runs = kernels.runs(cells_);
  context_.launch(kernels.vectors(), "dot_runs", kernels.items(static_cast<std::size_t>(runs)),
                  static_cast<int>(cells_), runs, a, b, partial_);
  sum_partial(kernels, static_cast<std::size_t>(runs), scalar);
}

void BatchedCg::sum_partial(const LaneKernels& kernels, std::size_t count,
                            const device::Buffer& scalar) {
  const auto sum = [&](std::size_t from, std::size_t to, const device::Buffer& in,
                       const device::Buffer& out) {
    context_.launch(kernels.vectors(), "sum_stripes", kernels.items(to), static_cast<int>(from),
                    static_cast<int>(to), in, out);
  };
  if (count <= few_partials) {
    sum(count, 1, partial_, scalar);
  } else {
    sum(count, most_stripes, partial_, stripes_);
    sum(most_stripes, 1, stripes_, scalar);
  }
}

BatchedCg::Scalars BatchedCg::replace_residual(const LaneKernels& kernels, const device::Buffer& b,
                                               const device::Buffer& x, bool first) {
  const int runs = kernels.runs(cells_);
  context_.launch(kernels.vectors(), "gather_solution",
                  kernels.items(static_cast<std::size_t>(runs)), static_cast<int>(cells_), runs,
                  int{first}, x, total_);
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  context_.launch(kernels.level_operator(), "residual_accurate", kernels.rows(s), s.nx, s.ny, s.nz,
                  level.gx, level.gy, level.gz, level.sink, total_, b, r_, partial_);
  sum_partial(
      kernels,
      s.cells() / static_cast<std::size_t>(s.nx) * static_cast<std::size_t>(kernels.segments(s)),
      rr_);
  return read_scalars(kernels, rr_);
}

BatchedCg::Scalars BatchedCg::read_scalars(const LaneKernels& kernels,
                                           const device::Buffer& scalar) {
  const auto lanes = static_cast<std::size_t>(kernels.lanes());
  Scalars values(lanes);
  if (format_.accurate_sums) {
    context_.read(scalar, values.data(), lanes * sizeof(double));
    return values;
  }
  std::vector<float> rounded(lanes);
  context_.read(scalar, rounded.data(), lanes * sizeof(float));
  std::copy(rounded.begin(), rounded.end(), values.begin());
  return values;
}

}  // namespace kappamu::forward
