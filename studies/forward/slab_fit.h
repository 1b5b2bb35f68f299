// Coefficients of measured slabs from their totals, by diffusion and by transport: the iteration of
// docs/theory.md ("Transport correction") on two data and two unknowns that another program, too,
// found from the same measurement.
#pragma once

#include <array>
#include <cstdint>

#include "studies/forward/slab_data.h"

namespace kappamu::studies {

struct SlabCoefficients {
  double sigma_a = 0.0, sigma_s_prime = 0.0;  ///< [1/mm]
  /// Standard deviations of their logarithms by the photons' noise and that of the totals stated; 0
  /// by diffusion.
  double log_sigma_a_std = 0.0, log_sigma_s_std = 0.0;
  int refreshes = 0;  ///< of r; 0 by diffusion
  bool settled = false;
};

/// M_R and M_T by diffusion explain `slab`'s.
SlabCoefficients fit_by_diffusion(const MeasuredSlab& slab);
/// r M does, r = transport over diffusion, with its slope: three walks of `photons` per refresh,
/// begun at `start`, ended where it moves no logarithm by more than their noise or 0.01. `error`:
/// standard error of the totals measured [share of incident light].
SlabCoefficients fit_by_transport(const MeasuredSlab& slab, const SlabCoefficients& start,
                                  double error, std::uint64_t photons, std::uint64_t seed);

}  // namespace kappamu::studies
