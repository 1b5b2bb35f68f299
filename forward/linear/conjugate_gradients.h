// Preconditioned conjugate gradients, once, for lanes of right-hand sides: a backend (host or
// OpenCL) gives the operations on its fields.
#pragma once

#include <cmath>
#include <utility>

#include "forward/linear/lanes.h"

namespace kappamu::forward::linear {

using Scalars = std::vector<double>;  ///< [lane]

/// a/b where b > 0, else 0.
inline Scalars quotients(const Scalars& a, const Scalars& b) {
  Scalars result(a.size(), 0.0);
  for (std::size_t lane = 0; lane < a.size(); ++lane) {
    if (b[lane] > 0.0) result[lane] = a[lane] / b[lane];
  }
  return result;
}

/// Solves for a batch's lights from x, and adds to `report` what came of them. The system has
///   start(b, x, lights)   r = b − A x from the lights' loads and fields; ‖b‖² and ‖r‖²
///   precondition(r_r)     z = M⁻¹ r; r·z
///   direct(along)         p = z + along p, q = A p; p·q
///   direct_to_ones()      p = 1, q = A p; r·p and p·q
///   advance(step)         x += step p, r −= step q; ‖r‖²
///   take(x, lights)       x into the lights' fields
template <class System>
void solve_batch(System& system, const std::vector<Load>& b, const std::vector<std::size_t>& lights,
                 std::vector<std::vector<double>>& x, const CgEnd& ends, CgReport& report) {
  auto [b_b, r_r] = system.start(b, x, lights);
  Scalars r_z(r_r.size(), 0.0), before = r_z;
  const auto reached = [&](std::size_t lane) {
    return ends.reached(lights[lane], r_r[lane], b_b[lane], r_z[lane], before[lane]);
  };
  const auto done = [&] {
    for (std::size_t lane = 0; lane < lights.size(); ++lane) {
      if (!reached(lane)) return false;
    }
    return true;
  };
  int iteration = 0;
  for (; !done(); ++iteration) {
    if (iteration == ends.most_iterations) {
      report.converged = false;
      break;
    }
    before = std::exchange(r_z, system.precondition(r_r));
    const Scalars p_q = system.direct(quotients(r_z, before));
    r_r = system.advance(quotients(r_z, p_q));
  }
  // The constant that makes the residual sum to zero.
  const auto [missing, whole] = system.direct_to_ones();
  r_r = system.advance(quotients(missing, whole));
  report.iterations = std::max(report.iterations, iteration);
  for (std::size_t lane = 0; lane < lights.size(); ++lane) {
    report.residual[lights[lane]] = b_b[lane] > 0.0 ? std::sqrt(r_r[lane] / b_b[lane]) : 0.0;
  }
  system.take(x, lights);
}

}  // namespace kappamu::forward::linear
