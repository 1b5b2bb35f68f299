// Conjugate gradients, preconditioned by multigrid, on a batch of patterns, each with its own
// scalars.
//
// Storage is float, yet residuals far below float's reach are met: the solution is the sum of two
// floats, x and a correction d, and once the residual has fallen by two decades the true one,
// b − A (x + d) with arithmetic in double, replaces it (van der Vorst & Ye 2000, "Residual
// replacement strategies for Krylov subspace iterative methods"). Convergence is only ever declared
// on the true residual.
#pragma once

#include <memory>
#include <vector>

#include "device/context.h"
#include "forward/grid/opencl/kernels/grid_kernels.h"
#include "forward/grid/opencl/multigrid/cg_steps.h"
#include "forward/grid/opencl/multigrid/grid_hierarchy.h"

namespace kappamu::forward {

class BatchedCg {
 public:
  /// Vectors for at most `lanes` patterns at once, in the hierarchy's workspace.
  BatchedCg(device::Context& context, const Format& format, const Hierarchy& hierarchy,
            Layout layout, int lanes);

  struct Result {
    int iterations = 0;
    bool stagnated = false;        ///< more iterations would not lower the true residual
    std::vector<double> residual;  ///< [lane] true ‖b − A x‖/‖b‖; 0 where b = 0
  };
  /// Solves A x = b from x, zero or given. Both have kernels.lanes()
  /// lanes.
  Result solve(const LaneKernels& kernels, const device::Buffer& b, const device::Buffer& x,
               InitialGuess guess, const SolveOptions& options);

  /// out = A in
  void apply(const LaneKernels& kernels, const device::Buffer& in, const device::Buffer& out);

 private:
  device::Context& context_;
  const Hierarchy& hierarchy_;
  std::unique_ptr<CgSteps> steps_;
};

}  // namespace kappamu::forward
