// The derivatives of the grid's equations, of its light and of its exitance by log κ and log μ of
// each voxel, boundary conductances and first-collision source included: exact for the discrete
// model (docs/theory.md, section 3). [W] (7) is the continuous limit of the face and cell sums
// alone.
#pragma once

#include <span>
#include <vector>

#include "core/optics.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// Of a boundary face of edge h below a voxel of κ: G_b [mm²].
struct RobinFace {
  double voxel_mm;
  double A;

  double conductance(double kappa) const { return robin_conductance(kappa, voxel_mm, A); }
  /// ∂ log G_b/∂ log κ = G_b/(2hκ).
  double log_slope(double kappa) const { return conductance(kappa) / (2.0 * voxel_mm * kappa); }
};

/// The sums over patterns that a gradient is made of, λ_m being the adjoint field of pattern m:
/// A λ_m = (∂M/∂φ)ᵀ ψ_m, ψ_m = ∂J/∂M_m.
struct AdjointSums {
  PairProducts products;        ///< of λ and φ
  std::vector<double> columns;  ///< Σ_m λ_i E_m: GridSolver::column_products
  /// Σ_m ψ_m (M_m − M_apart,m) on the seen faces, [face][v][u]; M_apart is the part of
  /// GridSolver::exitance that no conductance multiplies (exitance_per_irradiance on the lit face).
  std::vector<double> observed;
};

/// Adds ∂J/∂log κ and ∂J/∂log μ, where the sums were taken at `kappa` [mm] and `mu` [1/mm].
void add_gradient(const GridSetup& setup, const BoundaryConstants& constants,
                  std::span<const Face> seen, std::span<const double> kappa,
                  std::span<const double> mu, const AdjointSums& sums, CoefficientPair& gradient);

/// Along one direction, the same for every pattern: with A φ = b and the exitance M,
///     A δφ = δb − δA φ,      δM = (∂M/∂φ) δφ + (M − M_apart) δlog G_b.
struct Tangent {
  EquationsChange equations;
  std::vector<double> observed;  ///< δ log G_b of the seen faces' voxels, [face][v][u]
};

/// At `kappa` [mm] and `mu` [1/mm].
Tangent linearise(const GridSetup& setup, const BoundaryConstants& constants,
                  std::span<const Face> seen, std::span<const double> kappa,
                  std::span<const double> mu, const CoefficientPair& direction);

}  // namespace kappamu::forward
