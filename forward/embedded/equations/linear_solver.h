// Conjugate gradients preconditioned by one multigrid V-cycle, for several lights and media at
// once: what the reference and OpenCL implement alike.
//
// The smoother is Chebyshev's polynomial of the fourth kind (Lottes 2023), which needs
// nothing but the bound of the scaled spectrum that Level::inverse_scale provides; the same before
// and after the coarse correction, so that the cycle is symmetric.
#pragma once

#include <cstddef>
#include <vector>

namespace kappamu::forward::embedded {

/// Of 2, 3 and 5 the last takes the least time on thin and jagged objects, and half the
/// iterations of 2. On levels of few unknowns, which cost little, twice as many steps halve the
/// iterations of spikes far thinner than a cube.
constexpr int smoothing_degree(std::size_t unknowns) {
  constexpr std::size_t few = 8000;
  return unknowns <= few ? 10 : 5;
}

/// Step k ≥ 2 of the smoother: z ← keep·z + gain·r/d after r ← r − A z; the first is gain·r/d.
struct SmoothingStep {
  float keep, gain;
};
constexpr SmoothingStep smoothing_step(int k) {
  const auto n = static_cast<float>(k);
  return {(2.0F * n - 3.0F) / (2.0F * n + 1.0F), (8.0F * n - 4.0F) / (2.0F * n + 1.0F)};
}

/// What a smoother's x begins with.
enum class Start { zero, given };

/// When every light is solved for, or iterations are used up.
struct CgEnd {
  double residual = 0.0;  ///< of the right-hand side's length
  int most_iterations = 100;
  /// By light: of the error, eᵀ A e, predicted from the last two steps; empty: residuals alone end.
  std::vector<double> energy = {};

  bool reached(std::size_t light, double r_r, double b_b, double r_z, double r_z_before) const {
    if (r_r <= residual * residual * b_b) return true;
    // Preconditioned, rᵀ z is the error's energy before a step, which lowers it as the last one
    // did.
    return !energy.empty() && r_z_before > 0.0 && r_z * r_z <= energy[light] * r_z_before;
  }
};

struct CgReport {
  int iterations = 0;
  bool converged = true;
  std::vector<double> residual;  ///< per light, by the solver's measure; ‖b − A x‖/‖b‖ if not said
};

/// A right-hand side with the medium it is for.
struct Load {
  std::size_t channel = 0;
  std::vector<double> power;  ///< per unknown [mm²]
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

}  // namespace kappamu::forward::embedded
