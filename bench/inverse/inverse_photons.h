// Fits, by diffusion and by transport, of data that Monte Carlo transport made: what the model
// itself costs.
#pragma once

#include <cstdint>
#include <string>

#include "bench/inverse/inverse_fit.h"

namespace kappamu::bench {

struct PhotonOptions {
  std::string device = "auto";
  std::uint64_t per_pattern = 4'000'000;  ///< photons
  std::uint64_t seed = 1;
  int validation_patterns = 16;  ///< of the 8 × 8 held-out patches, spread evenly
  double noise = 0.01;           ///< added to what the photons' own makes, as add_noise() does
};

/// A row of each fit: score_of() it with its photons and renewals of r, validation_E against
/// photons under the physics it was fitted by (the noise of both photons taken off), truth_E (the
/// same of the true coefficients solved by diffusion) and photon_noise_E (what the validating
/// photons' noise adds to E, taken off). `fine_fields` on block.grid.refined(2), where the photons
/// walk; 4 × 4 patches are fitted, always as a volume.
Json fit_monte_carlo(const Block& block, const inverse::CoefficientPair& fine_fields,
                     const inverse::FitOptions& fit, const PhotonOptions& options,
                     Progress& progress);

}  // namespace kappamu::bench
