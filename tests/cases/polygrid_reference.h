// A polygrid's equations solved without levels, lanes or single precision: what its solvers are
// compared with.
#pragma once

#include "forward/polygrid/linear_solver.h"

namespace kappamu::forward::polygrid {

/// Serial, in double precision, written to be read: the matrix by rows, conjugate gradients scaled
/// by its diagonal until ‖residual‖ ≤ tolerance·‖load‖. Keeps a reference.
std::unique_ptr<LinearSolver> make_reference_solver(const Equations& equations);

}  // namespace kappamu::forward::polygrid
