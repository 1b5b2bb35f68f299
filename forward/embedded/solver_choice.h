// Which of the linear solvers answers: the one place that knows them both.
#pragma once

#include <memory>
#include <string>

#include "forward/embedded/equations/levels.h"
#include "forward/linear/linear_solver.h"

namespace kappamu::forward::embedded {

using linear::LinearSolver;

/// "reference" is the host's; "auto" takes a GPU where there is one, else the processor by OpenCL
/// where that is faster than the host's threads (embedded.md), else these; other words name an
/// OpenCL device. `lights`: right-hand sides over all channels. Keeps a reference to `levels`.
/// Throws InputError as device::choose and linear::make_opencl_solver do.
std::unique_ptr<LinearSolver> make_linear_solver(const Levels& levels, std::size_t lights,
                                                 const std::string& device);

}  // namespace kappamu::forward::embedded
