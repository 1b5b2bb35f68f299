// Conjugate gradients with the diagonal as preconditioner, on one batch: not a baseline of its own,
// but what brings stencil (8) to its discrete solution in reasonable time.
#pragma once

#include "studies/baseline/batch.h"

namespace kappamu::studies::baseline {

using namespace forward;

struct DiagonalCgResult {
  int iterations = 0;
  bool stagnated = false;        ///< rounding undoes what more iterations gain
  std::vector<double> residual;  ///< [pattern] ‖b − A x‖/‖b‖, recomputed from x
};

/// Solves A x = b from zero. x is an accurate field (Batch::make_accurate_field).
DiagonalCgResult diagonal_cg(const Batch& batch, const DeviceStencil& stencil,
                             const device::Buffer& b, const device::Buffer& x,
                             const SolveOptions& options);

}  // namespace kappamu::studies::baseline
