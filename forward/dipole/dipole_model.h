// Models `dipole`, `dipole-rotated`, `local-diffusion`, `better-dipole` and `beam-diffusion`:
// homogeneous objects by the BSSRDF of a half-space ([T] chapter 3), the fastest answer and the
// least exact (docs/dipole.md).
#pragma once

#include "forward/registry.h"

namespace kappamu::forward {

/// `dipole` places sources along the normal and sums over all pairs of triangles; the others place
/// them reciprocally and sum by the hierarchy on `device`, `local-diffusion` by samples about every
/// triangle.
///
/// Beams add what they bring through the surface to the irradiance of the triangle they meet: the
/// BSSRDF does not know their direction inside. The error estimate is that of the summation alone,
/// measured at a few triangles against the direct sum; what the half-space costs on the shape
/// is in the warnings and in `absorbed`, which is negative where more leaves than enters.
ModelDescription dipole_model();
ModelDescription rotated_dipole_model();
ModelDescription local_diffusion_model();
ModelDescription better_dipole_model();
ModelDescription beam_diffusion_model();

}  // namespace kappamu::forward
