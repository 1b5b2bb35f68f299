// Real slabs: total reflectance and transmittance predicted by diffusion and by Monte Carlo from
// given coefficients, beside what integrating spheres measured.
//
// Modelled: normal incidence, specular reflection, both glass slides (as what they reflect, clear
// and incoherent), the beam's own reflection at the far side, unscattered light, and for one
// sphere its gain G(sample, third port) and the bounce r off its wall that a baffle asks of
// scattered light before it is seen:
//     M_R = [r (R − R_u) + r_w R_u] G(R_d, 0)/G(r_std, 0),
//     M_T = [r (T − T_u) + r_3 T_u] G(R_d, r_3)/G(0, r_3),
// R_u, T_u the unscattered parts, R_d the reflectance for diffuse light, r_w the wall's, r_3 the
// transmission sphere's third port. This is the model that iad 4-0-0 inverted to find the
// coefficients; a standard seen through the same baffle would raise M_R by 1/r. Not modelled: light
// lost sideways past the ports, light scattered by the slides.
#pragma once

#include <cstdint>
#include <vector>

#include "studies/forward/slab_data.h"
#include "studies/forward/slab_fit.h"
#include "studies/forward/slab_photons.h"
#include "studies/subject.h"

namespace kappamu::studies {

/// Diffusion: closed form, first-collision source, exact A of the slide; standard errors 0. Diffuse
/// incidence enters through q, after the surface's own diffuse reflection.
SlabTotals diffuse_slab(const OpticalSlab& slab, Incidence incidence);

struct SlabPrediction {
  double reflectance = 0.0, transmittance = 0.0;              ///< M_R, M_T
  double reflectance_error = 0.0, transmittance_error = 0.0;  ///< standard errors
};

/// What `slab`'s spheres would show of its coefficients; `photons` of normal incidence, and as many
/// of diffuse light where a sphere needs it.
SlabPrediction slab_by_diffusion(const MeasuredSlab& slab);
SlabPrediction slab_by_photons(const MeasuredSlab& slab, std::uint64_t photons, std::uint64_t seed);

struct SlabComparison {
  MeasuredSlab measured;
  SlabPrediction diffusion, monte_carlo;
  SlabCoefficients fitted_by_diffusion, fitted_by_transport;  ///< where asked for
};

struct SlabOptions {
  int every = 1;  ///< of files with more than `spectrum` rows: one row in so many
  std::size_t spectrum = 40;
  /// Per row, and as many for diffuse light where a sphere needs it.
  std::uint64_t photons = 100'000;
  std::uint64_t seed = 1;
  bool fit = false;
};

std::vector<SlabComparison> compare_slabs(const std::vector<MeasuredSlab>& slabs,
                                          const SlabOptions& options, Progress& progress);

}  // namespace kappamu::studies
