// The regulariser R of u = log κ and log μ, dimensionless, independent of the grid and of the unit
// of length; ℓ is the thickness of the block along the light. Of an object only pairs of voxels
// that both lie inside are compared, and the anchor counts a voxel by its share inside. [W] smooths
// κ alone, on which μ runs away.
//
//   H1        R = (1/ℓ) ∫ ½ |∇v|² dV
//   Huber-TV  R = (1/ℓ) ∫ ψ(|∇v|) dV,  ψ(s) = ½ s² up to δ = t/ℓ, then δ s − ½ δ²
//
// v is the pair of log κ and (log μ)/3, |∇v|² the sum over both: `absorbers_vary` times as much as
// log κ may log μ vary for the same R.
//
// Huber-TV smooths slopes below t per thickness as H1 does and charges steeper ones by their height
// alone, so that edges may be sharp (total variation, rounded off); one of both coefficients costs
// less than two (vectorial total variation, Bresson & Chan 2008). Its Hessian is nowhere larger
// than H1's, whose metric therefore serves both. |∇v|² of a voxel is the mean of its two faces'
// squared differences along each axis, 0 beyond the block: for t → ∞ the sum is
// ½ (h/ℓ) Σ_faces (v_i − v_j)².
//
// Differences leave a constant free, and data of a block with little absorption leave log μ free.
// An anchor therefore adds ½ (h/ℓ) Σ_voxels (h/L)² (v_i − v*)², a pull towards the homogeneous
// start. It matters only where neither data nor neighbours determine the fields: differences
// outweigh it in fields that vary over less than L.
#pragma once

#include <optional>
#include <vector>

#include "core/names.h"
#include "inverse/problem/fields.h"

namespace kappamu::inverse {

enum class RegulariserKind {
  h1,
  huber_tv,
  /// R = ½ scale Σ_voxels |∇κ|², κ itself and alone, no anchor ([W] (6)): depends on the grid.
  wang2008
};
inline constexpr Names<RegulariserKind, 3> regulariser_names{
    {{"h1", RegulariserKind::h1},
     {"huber-tv", RegulariserKind::huber_tv},
     {"wang2008", RegulariserKind::wang2008}}};

/// Deviation of log μ over that of log κ between neighbours that R takes for equally likely:
/// pigments and veins absorb differently where scattering is nearly the same. 2.1 to 2.5 in the
/// simulated samples, and what smooth fields cannot follow adds as much (docs/theory.md, 4 and 5).
inline constexpr double absorbers_vary = 3.0;

struct Regulariser {
  RegulariserKind kind = RegulariserKind::h1;
  double edge_slope = 1.0;  ///< t of Huber-TV [log units per thickness]
  double scale = 1.0;       ///< multiplies [W]'s R
};

/// Values that the fields are drawn to, and the length of features from which that matters.
struct Anchor {
  double log_kappa = 0.0;  ///< κ in mm
  double log_mu = 0.0;     ///< μ in 1/mm
  double length_mm = 1.0;  ///< L
};

/// R and its gradient with respect to the fields.
struct Roughness {
  double value = 0.0;
  CoefficientPair gradient;
  /// ψ'(|∇v|)/|∇v| of every voxel, in (0, 1]; empty where it is 1 everywhere: H1.
  std::vector<double> diffusivity;
};
/// `storage`: of an earlier call, overwritten.
Roughness roughness(const MediumSpace& space, const CoefficientPair& fields,
                    const std::optional<Anchor>& anchor = std::nullopt,
                    const Regulariser& regulariser = {}, Roughness storage = {});

/// Factor on ½ (v − v*)² of a voxel whose factor on the squared differences is `scale`.
double anchor_scale(const MediumSpace& space, double scale, double length_mm);

/// `change` times the Hessian of the Gaussian that stands for R at some fields: H1's, with the
/// differences across a face weighed by the mean of its two voxels' `diffusivity` there (lagged
/// diffusivity, Vogel & Oman 1996). Its quadratic form touches Huber-TV at those fields, with the
/// same gradient, and lies nowhere below it. An empty diffusivity is H1's own. `anchor_length_mm`
/// is Anchor::length_mm.
CoefficientPair smoothing_product(const MediumSpace& space, double anchor_length_mm,
                                  const std::vector<double>& diffusivity,
                                  const CoefficientPair& change);

/// The weight at which H1's Hessian bounds that of α R: what the fit's metric is made with
/// (basis.h). For [W]'s R that is at `kappa` [mm] and for log κ.
double metric_weight(const Regulariser& regulariser, double weight, const MediumSpace& space,
                     double kappa);

}  // namespace kappamu::inverse
