// How the discrete equations change along a direction of (log κ, log μ): with A φ = b and the
// exitance M,
//     A δφ = δb − δA φ,      δM = (∂M/∂φ) δφ + (M − M_apart) δlog G_b.
// The forward twin of adjoint.h: the same derivatives, so that the two are each other's transpose
// to the solver's tolerance.
#pragma once

#include <span>
#include <vector>

#include "forward/grid/grid_solver.h"
#include "inverse/problem/adjoint.h"

namespace kappamu::inverse {

/// Derivatives along one direction; the same for every pattern.
struct Tangent {
  forward::EquationsChange equations;
  std::vector<double> observed;  ///< δ log G_b of the seen face's voxels, [v][u] [dimensionless]
};

/// At `kappa` [mm] and `mu` [1/mm].
Tangent linearise(const forward::GridSetup& setup, const BoundaryConstants& constants,
                  Face seen_face, std::span<const double> kappa, std::span<const double> mu,
                  const CoefficientPair& direction);

}  // namespace kappamu::inverse
