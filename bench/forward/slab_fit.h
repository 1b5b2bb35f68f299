// Measured slabs inverted by diffusion with transport's ratio r, the way a fit of a block is
// (docs/theory.md, 4, transport correction): two totals, two coefficients.
#pragma once

#include <cstdint>

#include "bench/forward/slab_data.h"
#include "bench/forward/slabs.h"

namespace kappamu::bench {

struct SlabFit {
  double sigma_a = 0.0, sigma_s_prime = 0.0;              ///< [1/mm]
  double sigma_a_error = 0.0, sigma_s_prime_error = 0.0;  ///< of the photons' noise, relative
  int renewals = 0;                                       ///< of r
  bool settled = false;  ///< the last one moved neither by more than 0.2 % or its error
};

/// From the diffusion fit that `start` of published coefficients is times `factor`: the same end is
/// to come of any. `transport` false: that fit itself, r = 1.
SlabFit fit_slab(const MeasuredSlab& slab, bool transport, std::uint64_t photons,
                 std::uint64_t seed);

}  // namespace kappamu::bench
