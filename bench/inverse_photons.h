// A fit of data that Monte Carlo transport made instead of diffusion: what the model itself costs.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "bench/inverse_fit.h"

namespace kappamu::bench {

struct PhotonOptions {
  std::string device = "auto";
  std::uint64_t per_pattern = 4'000'000;  ///< photons
  std::uint64_t seed = 1;
  int judged_patterns = 16;  ///< of the 8 × 8 held-out patches, spread evenly
  double noise = 0.01;       ///< added to what the photons' own makes, as add_noise() does
};

struct PhotonFit {
  FitScore score;            ///< patches_error: against photons, their own noise taken off
  double truth_error = 0.0;  ///< the same E of the true coefficients solved by diffusion
  double noise_error = 0.0;  ///< what the judging photons' noise adds to E, taken off both
};

/// `fine_fields` on block.grid.refined(2), where the photons walk; 4 × 4 patches are fitted.
PhotonFit fit_monte_carlo(const Block& block, const inverse::CoefficientPair& fine_fields,
                          const inverse::FitOptions& fit, const PhotonOptions& options,
                          Progress& progress);

nlohmann::ordered_json to_json(const PhotonFit& fit);
PhotonFit photon_fit_from_json(const nlohmann::ordered_json& object);

}  // namespace kappamu::bench
