// The solvers of the papers behind the common interface of forward models, to be charted beside
// ours: relaxation, [W] 5.3's hierarchical and adaptive schemes on our discretisation, and [W]
// equation (8)'s discretisation. Light and exitance are GridSolver's. On OpenCL devices only.
#pragma once

#include <memory>

#include "forward/forward_model.h"

namespace kappamu::forward {

/// Sweeps allowed where nothing is said; relaxation needs thousands.
inline constexpr int baseline_sweeps = 200'000;

/// Jacobi relaxation (Stam 1995, [W] 5.2).
std::unique_ptr<ForwardModel> make_relaxation_model();
/// Red-black Gauss-Seidel relaxation, [T] 4.2.2's smoother alone.
std::unique_ptr<ForwardModel> make_gauss_seidel_model();
/// [W] 5.3: solutions of coarser grids start Jacobi relaxation on finer ones.
std::unique_ptr<ForwardModel> make_hierarchical_model();
/// [W] 5.3: moreover, cells deep below the surface keep their coarse values. Residuals count the
/// others only, and the answer's distance to the solution is bounded by the depth, not by the
/// tolerance.
std::unique_ptr<ForwardModel> make_adaptive_model();
/// [W] equation (8), ∇²(κφ) − μφ = 0, solved by conjugate gradients: what its discretisation
/// answers, whatever solves it.
std::unique_ptr<ForwardModel> make_wang2008_stencil_model();

}  // namespace kappamu::forward
