// Chain rule from what the device sums over patterns (forward/grid/grid_solver.h) to the gradient
// with respect to log κ and log μ of each voxel. Discretise, then differentiate: exact for the
// discrete model, boundary conductances and first-collision source included (docs/theory.md,
// section 3); [W] (7) is the continuous limit of the face and cell sums alone.
#pragma once

#include <span>
#include <vector>

#include "forward/grid/grid_solver.h"

namespace kappamu::inverse {

/// One value per voxel for each coefficient, [z][y][x].
struct CoefficientPair {
  std::vector<double> log_kappa;
  std::vector<double> log_mu;

  bool operator==(const CoefficientPair&) const = default;
};

/// e^log of every element.
std::vector<double> exponential(const std::vector<double>& log);

Medium to_medium(const CoefficientPair& fields, const GridShape& shape);
/// And back: the logarithms of every voxel.
CoefficientPair to_fields(const Medium& medium);

/// The sums over patterns that a gradient is made of, λ_m being the adjoint field of pattern m:
/// A λ_m = (∂M/∂φ)ᵀ ψ_m, ψ_m = ∂J/∂M_m.
struct AdjointSums {
  forward::PairProducts products;  ///< of λ and φ
  std::vector<double> columns;     ///< Σ_m λ_i E_m: GridSolver::column_products
  /// Σ_m ψ_m (M_m − M_apart,m) on the seen face, [v][u]; M_apart is the part of
  /// GridSolver::exitance that no conductance multiplies (forward::exitance_per_irradiance on the
  /// lit face).
  std::vector<double> observed;

  void add(AdjointSums&& other);
};

/// ∂J/∂log κ and ∂J/∂log μ, where the sums were taken at `kappa` [mm] and `mu` [1/mm].
CoefficientPair assemble_gradient(const forward::GridSetup& setup,
                                  const BoundaryConstants& constants, Face seen_face,
                                  std::span<const double> kappa, std::span<const double> mu,
                                  const AdjointSums& sums);

}  // namespace kappamu::inverse
