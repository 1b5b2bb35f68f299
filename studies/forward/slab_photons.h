// Monte Carlo of a laterally infinite slab between two equal glass slides: the totals an
// integrating sphere sees. The voxel reference (forward/montecarlo) has no slides and answers for
// them by pixel; tests/studies/slab_photons_test.cpp holds the two to each other where there are
// none.
#pragma once

#include <cstdint>

namespace kappamu::studies {

struct OpticalSlab {
  double n_sample = 1.33, n_slide = 1.0;  ///< a slide of index 1 is none
  double thickness = 1.0;                 ///< [mm]
  double sigma_a = 0.0;                   ///< absorption μ [1/mm]
  double sigma_s_prime = 1.0;             ///< reduced scattering [1/mm]
  double anisotropy = 0.0;                ///< Henyey-Greenstein g; σs = σs'/(1 − g)
};

struct SlabTotals {
  double reflected = 0.0, transmitted = 0.0;  ///< of incident power, specular and unscattered too
  double reflected_error = 0.0, transmitted_error = 0.0;  ///< standard errors
};

enum class Incidence { normal, diffuse };  ///< diffuse: Lambertian, from outside

/// Photon weights are lowered by absorption; equal input gives equal results.
SlabTotals trace_slab(const OpticalSlab& slab, Incidence incidence, std::uint64_t photons,
                      std::uint64_t seed);

}  // namespace kappamu::studies
