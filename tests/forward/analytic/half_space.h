// Closed forms of diffusion in unbounded and half-infinite homogeneous media: a point source, the
// dipole of the extrapolated boundary (Farrell, Patterson & Wilson 1992, with Haskell's exact A),
// and the total reflectance with the Robin condition kept exact.
//
// Lengths [mm], fluence and radiant exitance per unit of the beam's power (1/mm²), totals
// dimensionless. z = 0 is the surface; the beam enters along the normal and is refracted by the
// surface's transmittance at normal incidence.
#pragma once

#include "core/optics.h"
#include "forward/dipole/profile/profile.h"

namespace kappamu::forward {

/// φ at distance r > 0 [mm] from an isotropic point source of unit power in an unbounded medium,
/// e^(−μ_eff r)/(4πκr), μ_eff = √(μ/κ) [1/mm²].
double point_source_fluence(const Material& material, double r);

/// Flux per area away from that source, −κ dφ/dr [1/mm²].
double point_source_flux(const Material& material, double r);

/// How a narrow beam becomes a diffuse source.
enum class BeamSource {
  one_depth,       ///< all first collisions at one mean free path, z = 3κ: the classic dipole
  first_collision  ///< along e^(−z/(3κ)): what the grid solvers do
};

/// Exitance at distance r > 0 from a beam of unit incident power, by image sources about the plane
/// z = −2Aκ where φ extrapolates to 0 [1/mm²].
double dipole_exitance(const Material& material, const BoundaryConstants& constants,
                       BeamSource source, double r);

/// ∫ dipole_exitance dA: diffuse reflectance of the half-space under the same approximation.
double dipole_reflectance(const Material& material, const BoundaryConstants& constants,
                          BeamSource source);

/// Diffuse reflectance under the first-collision source with φ − 2Aκφ' = 0 kept as it is:
/// T σs'/((σt' + μ_eff)(1 + 2Aκμ_eff)).
double half_space_reflectance(const Material& material, const BoundaryConstants& constants);

}  // namespace kappamu::forward
