// Radiative transfer in closed meshes by Monte Carlo behind the common interface of models of
// objects: what diffusion is compared with. docs/montecarlo.md, "Objects".
#pragma once

#include "forward/registry.h"

namespace kappamu::forward {

/// Of its parameter `photons`, on blocks and objects alike.
inline constexpr Bounds photons_bounds{.least = 2.0, .most = 2147483649.0, .closed = true};

/// `seed` and `follow_reentry` concern it; `device` does not, it runs on all cores. Equal options
/// give equal bits on any number of cores. σs' = 1/(3κ) − μ, isotropic; beams refract into the
/// surface; of diffuse light, Lambertian outside, η²(1 − R_φ) is refracted in, and counts as
/// scattered from there. A sample that no photon reached has exitance 0 and the standard error that
/// one photon of full weight would make.
///
/// Where light that meets the object again is followed, exitance counts it each time it leaves, and
/// `entering` what enters again, so that the balance holds.
ModelDescription monte_carlo_model();

}  // namespace kappamu::forward
