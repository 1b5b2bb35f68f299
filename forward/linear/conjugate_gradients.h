// Preconditioned conjugate gradients, once, for lanes of right-hand sides: a backend (host or
// OpenCL) gives the operations on its fields and keeps the scalars where it computes.
#pragma once

#include <algorithm>
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

/// Where an iteration stands, as last looked at.
struct CgState {
  Scalars size;    ///< ‖r‖², or the answer's energy b·x
  Scalars r_z;     ///< of the last preconditioned residual
  Scalars before;  ///< r·z of the one before it
};

/// When the host looks at the scalars of a device, which waits meanwhile: only where the iteration
/// may be the last. Iterations in between are fewer than the fastest fall so far would need, so
/// that none is made in vain unless the fall becomes a third faster.
class Looks {
 public:
  bool due(int iteration) const { return iteration >= next_; }
  /// At an iteration: what ends it is `excess` times what it may be.
  void saw(int iteration, double excess) {
    constexpr double cautious = 0.75, most_unseen = 8.0;
    const double left = std::log(excess), fall = (left_ - left) / (iteration - last_);
    if (iteration > last_ && std::isfinite(fall)) fastest_ = std::max(fastest_, fall);
    const bool known = fastest_ > 0.0 && std::isfinite(left);
    next_ =
        iteration +
        (known ? static_cast<int>(std::clamp(cautious * left / fastest_, 1.0, most_unseen)) : 1);
    last_ = iteration;
    left_ = left;
  }

 private:
  int next_ = 0, last_ = 0;
  double left_ = 0.0, fastest_ = 0.0;
};

/// Iterates from r = b − A x until enough() before a residual is preconditioned or
/// preconditioned_enough() after it, both of the number of iterations. The system has
///   precondition()   z = M⁻¹ r; along = r·z / (r·z before), 0 in the first iteration
///   direct()         p = z + along p, q = A p; step = r·z / p·q
///   advance()        x += step p, r −= step q; the state's size
template <class System, class Enough, class PreconditionedEnough>
int conjugate_gradients(System& system, const Enough& enough,
                        const PreconditionedEnough& preconditioned_enough) {
  for (int iterations = 0;; ++iterations) {
    if (enough(iterations)) return iterations;
    system.precondition();
    if (preconditioned_enough(iterations)) return iterations;
    system.direct();
    system.advance();
  }
}

/// The largest excess(lane) of so many lanes, or one that is no number.
template <class Excess>
double largest_excess(std::size_t lanes, const Excess& excess) {
  double largest = 1.0;
  for (std::size_t lane = 0; lane < lanes && !std::isnan(largest); ++lane) {
    const double one = excess(lane);
    if (!(one <= largest)) largest = one;
  }
  return largest;
}

/// Solves for a batch's lights from x, and adds to `report` what came of them. Beside the above the
/// system has
///   start(b, x, lights)   r = b − A x from the lights' loads and fields; ‖b‖²
///   look()                the state; free of cost where looks_are_free
///   add_constant()        x += c, r −= c A 1 with the c that makes r sum to zero; ‖r‖²
///   take(x, lights)       x into the lights' fields
template <class System>
void solve_batch(System& system, const std::vector<Load>& b, const std::vector<std::size_t>& lights,
                 std::vector<std::vector<double>>& x, const CgEnd& ends, CgReport& report) {
  const Scalars b_b = system.start(b, x, lights);
  Looks looks;
  bool converged = false;
  const int iterations = conjugate_gradients(
      system,
      [&](int iteration) {
        const bool last = iteration == ends.most_iterations;
        if (!System::looks_are_free && !last && !looks.due(iteration)) return false;
        const CgState at = system.look();
        const double excess = largest_excess(lights.size(), [&](std::size_t k) {
          return ends.excess(lights[k], at.size[k], b_b[k], at.r_z[k], at.before[k]);
        });
        converged = excess <= 1.0;
        looks.saw(iteration, excess);
        return last || converged;
      },
      [](int) { return false; });
  report.converged = report.converged && converged;
  report.iterations = std::max(report.iterations, iterations);
  const Scalars r_r = system.add_constant();
  for (std::size_t k = 0; k < lights.size(); ++k) {
    report.residual[lights[k]] = b_b[k] > 0.0 ? std::sqrt(r_r[k] / b_b[k]) : 0.0;
  }
  system.take(x, lights);
}

}  // namespace kappamu::forward::linear
