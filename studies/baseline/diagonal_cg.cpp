#include "studies/baseline/diagonal_cg.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace kappamu::studies::baseline {

namespace {

using Scalars = std::vector<double>;  ///< [lane]

/// The largest √(rr/bb) over lanes that have light.
double worst(const Scalars& rr, const Scalars& bb) {
  double value = 0.0;
  for (std::size_t m = 0; m < rr.size(); ++m) {
    if (bb[m] > 0.0) value = std::max(value, std::sqrt(rr[m] / bb[m]));
  }
  return value;
}

/// a/b, and 0 for lanes that have nothing left to do.
Scalars quotient(const Scalars& a, const Scalars& b) {
  Scalars q(a.size(), 0.0);
  for (std::size_t m = 0; m < a.size(); ++m) q[m] = b[m] > 0.0 ? a[m] / b[m] : 0.0;
  return q;
}

}  // namespace

DiagonalCgResult diagonal_cg(const Batch& batch, const DeviceStencil& s, const device::Buffer& b,
                             const device::Buffer& x, const SolveOptions& options) {
  const auto cells = static_cast<int>(s.cells());
  const int runs = batch.runs();
  const device::Buffer r = batch.make_field(s.cells()), p = batch.make_field(s.cells()),
                       q = batch.make_field(s.cells());
  const device::Buffer sum_rr = batch.make_partial_sums(), sum_rz = batch.make_partial_sums(),
                       sum_pq = batch.make_partial_sums();
  const device::Buffer alpha = batch.make_scalars(), beta = batch.make_scalars();
  Scalars rr, rz;
  const auto read_sums = [&] {
    rr = batch.sum(sum_rr);
    rz = batch.sum(sum_rz);
  };
  const auto true_residual = [&] {
    batch.over_runs("cg_residual", s.n[0], s.n[1], s.n[2], s.gx, s.gy, s.gz, s.sink, s.inverse,
                    runs, b, x, r, sum_rr, sum_rz);
    read_sums();
  };

  true_residual();
  const Scalars bb = rr;  // x is zero
  DiagonalCgResult result;
  // Rounding lets the recursive residual drift from the true one. After three decades, where float
  // has not yet drifted far, the true one takes its place; a round that gains nothing ends it.
  constexpr double gain_per_round = 1e-3;
  double before = std::numeric_limits<double>::infinity(), now = worst(rr, bb);
  while (now > options.tolerance && result.iterations < options.max_iterations &&
         now < 0.5 * before) {
    before = now;
    const double goal = std::max(0.9 * options.tolerance, gain_per_round * before);
    batch.write_scalars(beta, Scalars(rr.size(), 0.0));
    while (now > goal && result.iterations < options.max_iterations) {
      batch.over_runs("cg_direction", cells, runs, s.inverse, beta, r, p);
      batch.over_runs("cg_apply", s.n[0], s.n[1], s.n[2], s.gx, s.gy, s.gz, s.sink, runs, p, q,
                      sum_pq);
      batch.write_scalars(alpha, quotient(rz, batch.sum(sum_pq)));
      batch.over_runs("cg_step", cells, runs, s.inverse, alpha, p, q, x, r, sum_rr, sum_rz);
      const Scalars rz_before = std::move(rz);
      read_sums();
      batch.write_scalars(beta, quotient(rz, rz_before));
      now = worst(rr, bb);
      ++result.iterations;
    }
    true_residual();
    now = worst(rr, bb);
  }
  result.stagnated = now > options.tolerance && result.iterations < options.max_iterations;
  result.residual = quotient(rr, bb);
  result.residual.resize(static_cast<std::size_t>(batch.patterns()));
  for (double& value : result.residual) value = std::sqrt(value);
  return result;
}

}  // namespace kappamu::studies::baseline
