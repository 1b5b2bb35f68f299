// The OpenCL backend of GridSolver.
#pragma once

#include <memory>

#include "device/context.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// Patterns solved at once where memory allows.
inline constexpr int full_lanes = 16;

enum class Trust {
  verify,  ///< kernels for a number of lanes pass solver_verdict() before their first use
  blind    ///< for that test itself
};

/// Throws InputError when the device lacks memory for the grid or double precision where asked,
/// DeviceError when its compiler fails or, on use, when kernels fail their known-answer test.
std::unique_ptr<GridSolver> make_opencl_solver(const GridSetup& setup, device::Context& context,
                                               Precision precision, Trust trust = Trust::verify);

}  // namespace kappamu::forward
