// The regulariser R = ½ Σ_{κ,μ} ∫|∇u|² dV / ℓ = ½ (h/ℓ) Σ_faces (u_i − u_j)² of u = log κ and log μ
// (H1), ℓ the thickness of the block along the light: dimensionless, independent of the grid and of
// the unit of length. [W] smooths κ alone, on which μ runs away.
#pragma once

#include "core/grid.h"
#include "inverse/adjoint.h"

namespace kappamu::inverse {

/// R and its gradient, which is linear in the fields: R = ½ fieldsᵀ gradient.
struct Roughness {
  double value = 0.0;
  CoefficientPair gradient;
};
Roughness roughness(const GridShape& shape, double thickness_mm, const CoefficientPair& fields);

}  // namespace kappamu::inverse
