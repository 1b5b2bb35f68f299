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

/// Where an iteration stands.
struct CgState {
  Scalars size;    ///< what advance() returns: ‖r‖², or the answer's energy b·x
  Scalars r_z;     ///< of the last preconditioned residual
  Scalars before;  ///< r·z of the one before it
  int iterations = 0;

  explicit CgState(Scalars first) : size(std::move(first)), r_z(size.size(), 0.0), before(r_z) {}
};

/// Iterates from r = b − A x until enough() before a residual is preconditioned or
/// preconditioned_enough() after it. The system has
///   precondition(size)   z = M⁻¹ r; r·z
///   direct(along)        p = z + along p, q = A p; p·q
///   advance(step)        x += step p, r −= step q; the state's size
template <class System, class Enough, class PreconditionedEnough>
void conjugate_gradients(System& system, CgState& at, const Enough& enough,
                         const PreconditionedEnough& preconditioned_enough) {
  for (;; ++at.iterations) {
    if (enough()) return;
    at.before = std::exchange(at.r_z, system.precondition(at.size));
    if (preconditioned_enough()) return;
    const Scalars p_q = system.direct(quotients(at.r_z, at.before));
    at.size = system.advance(quotients(at.r_z, p_q));
  }
}

/// Whether test(lane) holds for all of so many lanes.
template <class Test>
bool in_all_lanes(std::size_t lanes, const Test& test) {
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    if (!test(lane)) return false;
  }
  return true;
}

/// Solves for a batch's lights from x, and adds to `report` what came of them. Beside the above the
/// system has
///   start(b, x, lights)   r = b − A x from the lights' loads and fields; ‖b‖² and ‖r‖²
///   direct_to_ones()      p = 1, q = A p; r·p and p·q
///   take(x, lights)       x into the lights' fields
template <class System>
void solve_batch(System& system, const std::vector<Load>& b, const std::vector<std::size_t>& lights,
                 std::vector<std::vector<double>>& x, const CgEnd& ends, CgReport& report) {
  const auto [b_b, r_r] = system.start(b, x, lights);
  CgState at(r_r);
  const auto done = [&] {
    return in_all_lanes(lights.size(), [&](std::size_t k) {
      return ends.reached(lights[k], at.size[k], b_b[k], at.r_z[k], at.before[k]);
    });
  };
  conjugate_gradients(
      system, at, [&] { return at.iterations == ends.most_iterations || done(); },
      [] { return false; });
  report.converged = report.converged && done();
  report.iterations = std::max(report.iterations, at.iterations);
  // The constant that makes the residual sum to zero.
  const auto [missing, whole] = system.direct_to_ones();
  at.size = system.advance(quotients(missing, whole));
  for (std::size_t k = 0; k < lights.size(); ++k) {
    report.residual[lights[k]] = b_b[k] > 0.0 ? std::sqrt(at.size[k] / b_b[k]) : 0.0;
  }
  system.take(x, lights);
}

}  // namespace kappamu::forward::linear
