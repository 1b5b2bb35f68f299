// Conjugate gradients for several lights and media (colour channels) at once: what is solved and
// where an iteration ends, whatever the equations, the preconditioner and the device.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace kappamu::forward::linear {

/// A right-hand side with the medium it is for.
struct Load {
  std::size_t channel = 0;
  std::vector<double> power;  ///< per unknown [mm²]
};

/// When every light is solved for, or iterations are used up. M⁻¹ is the preconditioner, e the
/// error, r = b − A x the residual.
struct CgEnd {
  double residual = 0.0;  ///< ‖r‖ over ‖b‖
  int most_iterations = 100;
  /// By light: of the error, eᵀ A e, predicted from the last two steps; empty: not asked.
  std::vector<double> energy = {};
  /// √(r·M⁻¹r) over √(b·x), which estimate the energy norms of e and x; and, where more, the share
  /// of the first √(r·M⁻¹r).
  double relative_energy = 0.0;
  double of_first = 1.0;

  /// How many times what it may be a light's squared residual or error is; 1 where that is reached.
  double excess(std::size_t light, double r_r, double b_b, double r_z, double r_z_before) const {
    const double of_residual = over(r_r, residual * residual * b_b);
    if (energy.empty() || !(r_z_before > 0.0)) return of_residual;
    // Preconditioned, rᵀ z is the error's energy before a step, which lowers it as the last one
    // did.
    return std::min(of_residual, over(r_z * r_z, energy[light] * r_z_before));
  }
  double energy_excess(double r_z, double b_x, double first_r_z) const {
    return std::max(over(r_z, relative_energy * relative_energy * std::max(0.0, b_x)),
                    over(r_z, of_first * of_first * first_r_z));
  }

 private:
  static double over(double is, double may_be) {
    if (is <= may_be) return 1.0;
    return may_be > 0.0 ? is / may_be : HUGE_VAL;
  }
};

struct CgReport {
  int iterations = 0;
  bool converged = true;
  std::vector<double> residual;  ///< per light, by the solver's measure; ‖b − A x‖/‖b‖ if not said
};

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  /// Solves A x = b for every light, on a level of the hierarchy; begins with x, or with zero where
  /// x is empty, and ends as `ends` has it. The residual's sum is zero on return, so that the
  /// powers balance (embedded.md).
  virtual CgReport solve(const std::vector<Load>& b, std::vector<std::vector<double>>& x,
                         const CgEnd& ends, std::size_t level = 0) = 0;
};

}  // namespace kappamu::forward::linear
