// Radiative transfer in closed meshes by Monte Carlo behind the common interface of models of
// objects: what diffusion is compared with. docs/montecarlo.md, "Objects".
#pragma once

#include <memory>

#include "forward/object_model.h"

namespace kappamu::forward {

/// `photons` (per light, 2 to 2^31) and `seed` of the options concern it, and `follow_reentry`;
/// `device` does not, it runs on all cores. Equal options give equal bits on any number of cores.
/// σs' = 1/(3κ) − μ, isotropic; beams refract into the surface; of diffuse light, Lambertian
/// outside, η²(1 − R_φ) is refracted in, and counts as scattered from there. A sample that no
/// photon reached has exitance 0 and the standard error that one photon of full weight would make.
///
/// Where light that meets the object again is followed, exitance counts it each time it leaves, and
/// `entering` what enters again, so that the balance holds.
std::unique_ptr<ObjectModel> make_object_monte_carlo();

}  // namespace kappamu::forward
