// Diffuse reflectance of a homogeneous medium under light that varies as cos 2πf x, by diffusion in
// closed form: half-space, and slab of known thickness.
//
// All quantities are in units of the transport scattering length 1/σs', so that two numbers name a
// medium: a = μa/σs' and k = 2πf/σs'. Source: first collisions of a beam at normal incidence,
// boundary condition φ + 2Aκ ∂φ/∂n = 0 with the exact A (core/optics.h); the same equation as
// forward/analytic/layered_mode.h.
#pragma once

#include <optional>

namespace kappamu::forward {

/// Light that leaves through the lit surface over light that entered it, dimensionless, in (0, 1].
/// `a` ≥ 0 and `k` ≥ 0 dimensionless; `robin_A` as BoundaryConstants::A.
double diffuse_half_space(double a, double k, double robin_A);

/// Slab of `thickness` (in units of 1/σs', > 0) between surfaces of `surface_A` over the half-space
/// of the same medium under one of `robin_A`.
double slab_over_half_space(double a, double k, double robin_A, double surface_A, double thickness);

}  // namespace kappamu::forward
