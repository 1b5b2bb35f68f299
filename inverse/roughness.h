// The regulariser R = ½ Σ_{κ,μ} ∫|∇u|² dV / ℓ = ½ (h/ℓ) Σ_faces (u_i − u_j)² of u = log κ and log μ
// (H1), ℓ the thickness of the block along the light: dimensionless, independent of the grid and of
// the unit of length. [W] smooths κ alone, on which μ runs away.
//
// Differences do not see a constant, and where hardly anything is absorbed the data do not see log
// μ either: an anchor adds ½ (h/ℓ) Σ_voxels (h/L)² (u_i − u*)², a pull towards the homogeneous
// start that matters only where data and neighbours say nothing (fields that vary over less than L
// feel the differences more).
#pragma once

#include <optional>

#include "core/grid.h"
#include "inverse/adjoint.h"

namespace kappamu::inverse {

/// Where the fields are drawn to, and how far features reach before they feel it.
struct Anchor {
  double log_kappa = 0.0;  ///< κ in mm
  double log_mu = 0.0;     ///< μ in 1/mm
  double length_mm = 1.0;  ///< L
};

/// R and its gradient with respect to the fields.
struct Roughness {
  double value = 0.0;
  CoefficientPair gradient;
};
Roughness roughness(const GridShape& shape, double thickness_mm, const CoefficientPair& fields,
                    const std::optional<Anchor>& anchor = std::nullopt);

}  // namespace kappamu::inverse
