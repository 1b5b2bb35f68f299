// Fresnel reflection at a smooth dielectric surface and the constants of the diffusion boundary
// condition φ + 2Aκ ∂φ/∂n = q that follow from it (Haskell et al. 1994, exact partial currents of
// the P1 radiance). η is the medium's refractive index relative to the outside (η > 1); all results
// are dimensionless.
#pragma once

namespace kappamu {

/// Unpolarised Fresnel reflectance for light inside the medium meeting the surface, cos_inside the
/// cosine of its angle to the normal; 1 beyond the critical angle.
double fresnel_internal(double eta, double cos_inside);

/// The same for light arriving from outside, cos_outside the cosine of its angle to the normal.
double fresnel_external(double eta, double cos_outside);

struct BoundaryConstants {
  double eta = 1.0;
  double r_phi = 0.0;                 ///< R_φ = ∫₀¹ 2c R(c) dc, also called F_dr
  double r_j = 0.0;                   ///< R_j = ∫₀¹ 3c² R(c) dc
  double A = 1.0;                     ///< (1 + R_j)/(1 − R_φ)
  double normal_transmittance = 1.0;  ///< 1 − R at normal incidence: E_t = normal_transmittance · E

  /// The source q of the boundary condition φ + 2Aκ ∂φ/∂n = q over E_t, the irradiance that enters.
  double q_per_entering() const { return 4.0 / (1.0 - r_phi); }
};

// robin_conductance(κ, h, A), one text for host and kernels.
#define REAL double
#include "core/robin_conductance.inc"
#undef REAL

/// Integrates the Fresnel moments for η (Gauss-Legendre on either side of the critical angle; error
/// below 1e-12). Throws InputError unless 1 ≤ η ≤ 4.
BoundaryConstants boundary_constants(double eta);

/// The constants of [W] (wang2008) taken literally: C as printed, 2.1489, in A's place. Valid for η
/// = 1.3.
inline constexpr double wang2008_C = 2.1489;

/// Polynomial fit of F_dr (Groenhuis et al. 1983) that papers use: kept to reproduce them. At η
/// = 1.3 it gives (1+F_dr)/(1−F_dr) = 2.6021 where the integral gives 2.6001.
double fdr_polynomial(double eta);

/// Radiance over exitance, L/M [1/sr], of P1 light refracted out of a surface where nothing enters:
/// L = (1 − R(θ))/η² · (φ + 3M cosθ')/(4π) with φ = 2AM (docs/theory.md). cos_outside = cosθ in
/// air.
double radiance_per_exitance(const BoundaryConstants& constants, double cos_outside);

}  // namespace kappamu
