// Conjugate gradients preconditioned by one multigrid V-cycle, several right-hand sides at once.
//
// The smoother is Chebyshev's polynomial of the fourth kind (Lottes 2023), degree 2, which needs
// nothing but the bound of the scaled spectrum that Level::inverse_scale provides; the same before
// and after the coarse correction, so that the cycle is symmetric.
#pragma once

#include "forward/embedded/hierarchy.h"

namespace kappamu::forward::embedded {

struct CgReport {
  int iterations = 0;
  bool converged = false;
  std::vector<double> residual;  ///< ‖b − A x‖/‖b‖ per light
};

/// Solves A x = b for every light; b and x are [light][unknown]. The residual's sum is zero on
/// return, so that the powers balance (embedded.md).
CgReport solve(const Hierarchy& hierarchy, const std::vector<std::vector<double>>& b,
               std::vector<std::vector<double>>& x, double tolerance, int most_iterations);

}  // namespace kappamu::forward::embedded
