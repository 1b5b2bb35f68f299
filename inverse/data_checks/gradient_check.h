// Is the gradient that of the objective, and is the adjoint the transpose, on these very data? The
// two laws a fit stands on, checked where the user works: his grid, light, masks and variances.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// One step of the Taylor test: J(u + s d) − J(u) − s ⟨∇J, d⟩ must fall as s².
struct TaylorStep {
  double step = 0.0;       ///< s
  double remainder = 0.0;  ///< |J(u + s d) − J(u) − s ⟨∇J, d⟩| / J(u)
  /// Order of the fall from the step before, a decade larger; 0 for the first.
  double order = 0.0;
};

struct GradientCheck {
  std::vector<TaylorStep> taylor;
  /// Worst distance of an order from 2 over the steps.
  double worst_order_error = 0.0;
  double directional_derivative = 0.0;  ///< ⟨∇J, d⟩ / J(u)
  /// |⟨p, J' d⟩ / ⟨J'ᵀ p, d⟩ − 1|: Jacobian by differences of predictions, transpose by the
  /// adjoint.
  double adjoint_error = 0.0;
  /// |⟨A⁻¹ b, w⟩ / ⟨b, A⁻¹ w⟩ − 1|: the solver is its own adjoint.
  double symmetry_error = 0.0;
  SolveCount solves;
  std::string backend;
  std::string warning;  ///< empty, or one sentence the caller must show

  bool taylor_holds() const;
  bool adjoint_holds() const;
  bool symmetry_holds() const;
  bool holds() const { return taylor_holds() && adjoint_holds() && symmetry_holds(); }
};

/// What the checks hold the three figures to.
struct GradientBounds {
  static constexpr double order = 0.05;     ///< orders within 2 ± this, over three decades
  static constexpr double adjoint = 1e-6;   ///< what differences of predictions can tell
  static constexpr double symmetry = 1e-9;  ///< rounding and the solver's tolerance
};

/// Solves in double precision on `device` (as Backend::device) to 1e-12, since differences are only
/// as good as the solves: at the best homogeneous block with κ and μ of every voxel varied by 20 %,
/// along a random direction. Throws InputError when no datum stands above its noise, or a solve
/// does not converge.
GradientCheck check_gradient(const Problem& problem, const std::string& device, std::uint64_t seed);

}  // namespace kappamu::inverse
