// The OpenCL backend of GridSolver.
#pragma once

#include <memory>

#include "device/context.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// Throws InputError when the device lacks memory for the grid or double precision where asked,
/// DeviceError when its compiler fails. Does not test the device: make_grid_solver() does.
std::unique_ptr<GridSolver> make_opencl_solver(const GridSetup& setup, device::Context& context,
                                               Precision precision);

}  // namespace kappamu::forward
