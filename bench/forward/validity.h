// Where diffusion can be trusted: its error against Monte Carlo transport over albedo and optical
// thickness, on slabs under patch light.
//
// Each case is a slab of index 1.3 and transport mean free path 1 mm (κ = 1/3 mm, μ = 1 − albedo
// per mm, isotropic scattering), three thicknesses wide with mirror sides, lit by a collimated beam
// on a square as wide as the slab is thick, seen in pixels of an eighth of that. Diffusion is the
// closed form (forward/analytic/layered_block.h) with the first-collision source and exact A, so no
// grid's error enters. Diffuse light only: what crosses unscattered is left out on both sides.
// Reflected and transmitted are signed relative errors of the totals, lit_map and far_map relative
// L2 errors of the pixel maps less the noise's part; null where Monte Carlo's noise hides them.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

Subject validity_subject();

}  // namespace kappamu::bench
