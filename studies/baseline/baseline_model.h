// The solvers of the papers behind the common interface of forward models, to be charted beside
// ours: relaxation, [W] 5.3's hierarchical and adaptive schemes on our discretisation, and [W]
// equation (8)'s discretisation. Light and exitance are GridSolver's. On OpenCL devices only.
// Relaxation needs thousands of sweeps: SolveOptions::max_iterations is the caller's to raise.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "forward/forward_model.h"

namespace kappamu::studies::baseline {

/// "adaptive" keeps the coarse values of cells deep below the surface: its residuals count the
/// others only, and its distance to the solution is bounded by the depth, not by the tolerance.
const std::vector<forward::MethodName>& methods();

/// One of methods() or of forward_methods(). Throws InputError where neither has the name.
std::unique_ptr<forward::ForwardModel> make_model(const std::string& method);

}  // namespace kappamu::studies::baseline
