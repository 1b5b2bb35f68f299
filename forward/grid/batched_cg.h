// Conjugate gradients, preconditioned by multigrid, on a batch of patterns, each with its own
// scalars.
//
// Storage is float, yet residuals far below float's reach are met: the solution is gathered in
// double, and once the residual has fallen by three decades the true one, b − A x in double,
// replaces it (van der Vorst & Ye 2000, "Residual replacement strategies for Krylov subspace
// iterative methods"). Convergence is only ever declared on the true residual.
#pragma once

#include <vector>

#include "device/context.h"
#include "forward/grid/grid_hierarchy.h"
#include "forward/grid/grid_kernels.h"
#include "forward/grid/multigrid.h"

namespace kappamu::forward {

class BatchedCg {
 public:
  /// Work space for at most `lanes` patterns at once.
  BatchedCg(device::Context& context, const Format& format, const Hierarchy& hierarchy, int lanes);

  struct Result {
    int iterations = 0;
    bool stagnated = false;        ///< more iterations would not lower the true residual
    std::vector<double> residual;  ///< [lane] true ‖b − A x‖/‖b‖; 0 where b = 0
  };
  /// Solves A x = b from x. Both have kernels.lanes() lanes.
  Result solve(const LaneKernels& kernels, const device::Buffer& b, const device::Buffer& x,
               const SolveOptions& options);

  /// out = A in
  void apply(const LaneKernels& kernels, const device::Buffer& in, const device::Buffer& out);

 private:
  using Scalars = std::vector<double>;  ///< [lane]
  void apply_dot(const LaneKernels& kernels, const device::Buffer& in, const device::Buffer& out,
                 const device::Buffer& scalar);
  void dot(const LaneKernels& kernels, const device::Buffer& a, const device::Buffer& b,
           const device::Buffer& scalar);
  void sum_partial(const LaneKernels& kernels, std::size_t count, const device::Buffer& scalar);
  /// r = b − A (total + x), ‖r‖² of each lane; x moves into total and becomes zero.
  Scalars replace_residual(const LaneKernels& kernels, const device::Buffer& b,
                           const device::Buffer& x, bool first);
  Scalars read_scalars(const LaneKernels& kernels, const device::Buffer& scalar);

  device::Context& context_;
  Format format_;
  const Hierarchy& hierarchy_;
  Multigrid multigrid_;
  std::size_t cells_;
  device::Buffer r_, z_, p_, q_, total_;
  device::Buffer partial_, stripes_;
  device::Buffer rz_[2], pq_, rr_;
};

}  // namespace kappamu::forward
