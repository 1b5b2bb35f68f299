// The linear solver in OpenCL: fields stay on the device from the right-hand side to the solution.
// Lights of one medium, or one light of each of several media, are solved together as lanes of
// vectors.
#pragma once

#include <memory>

#include "device/context.h"
#include "forward/embedded/equations/levels.h"
#include "forward/embedded/equations/linear_solver.h"

namespace kappamu::forward::embedded {

/// Keeps references to both. Throws InputError where the device has no double precision or too
/// little memory.
std::unique_ptr<LinearSolver> make_opencl_multigrid(const Levels& levels, device::Context& context);

}  // namespace kappamu::forward::embedded
