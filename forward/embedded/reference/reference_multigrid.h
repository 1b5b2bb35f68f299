// The linear solver on the host: sparse rows and threads. What the one on OpenCL is compared with.
#pragma once

#include <memory>

#include "forward/embedded/equations/levels.h"
#include "forward/embedded/equations/linear_solver.h"

namespace kappamu::forward::embedded {

/// Keeps a reference to `levels`.
std::unique_ptr<LinearSolver> make_reference_multigrid(const Levels& levels);

}  // namespace kappamu::forward::embedded
