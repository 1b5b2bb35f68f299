// Is an OpenCL device's grid solver to be believed? A small jumpy block is solved on it and by the
// serial reference; they must agree.
#pragma once

#include <memory>
#include <string>

#include "device/context.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

struct Verdict {
  bool trusted = false;
  std::string message;  ///< one phrase: what agreed to how much, or what went wrong
};

/// Tests the kernels for batches of `lanes` patterns; remembered for the life of the process. Never
/// throws: whatever goes wrong is a verdict.
const Verdict& solver_verdict(device::Context& context, Precision precision, int lanes);

/// Outcome of device::self_test() and of the kernels for full batches together: what
/// make_grid_solver() decides by.
Verdict device_verdict(device::Context& context, Precision precision);

/// `solver` where the verdict is good, else the reference with a warning naming the device.
SolverChoice trusted_or_reference(std::unique_ptr<GridSolver> solver, const GridSetup& setup,
                                  const std::string& device_name, const Verdict& verdict);

}  // namespace kappamu::forward
