// How the discrete equations change along a direction of (log κ, log μ): with A φ = b and the
// exitance M,
//     A δφ = δb − δA φ,      δM = (∂M/∂φ) δφ + (M − M_apart) δlog G_b.
// The forward twin of adjoint.h: the same derivatives, so that the two are each other's transpose
// to the solver's tolerance.
#pragma once

#include <span>
#include <vector>

#include "forward/grid/grid_solver.h"
#include "inverse/adjoint.h"

namespace kappamu::inverse {

/// Derivatives of the equations' coefficients along one direction; the same for every pattern.
/// Volumes are [z][y][x].
struct Tangent {
  std::vector<double> face_x;    ///< δG_ij towards +x [mm]; 0 at the last x
  std::vector<double> face_y;    ///< the same towards +y
  std::vector<double> face_z;    ///< the same towards +z
  std::vector<double> diagonal;  ///< δ(μ h³ + Σ_b G_b) [mm²]
  std::vector<double> source;  ///< δb per irradiance of the voxel's column on the lit face [mm²]
  std::vector<double> observed;  ///< δ log G_b of the seen face's voxels, [v][u] [dimensionless]
};

/// At `kappa` [mm] and `mu` [1/mm].
Tangent linearise(const forward::GridSetup& setup, const BoundaryConstants& constants,
                  Face seen_face, std::span<const double> kappa, std::span<const double> mu,
                  const CoefficientPair& direction);

/// δb − δA φ of `patterns` patterns: `phi` and the result [pattern][z][y][x], `irradiance`
/// [pattern][v][u] on the lit face.
std::vector<double> tangent_source(const forward::GridSetup& setup, const Tangent& tangent,
                                   std::span<const double> phi, std::span<const double> irradiance,
                                   int patterns);

}  // namespace kappamu::inverse
