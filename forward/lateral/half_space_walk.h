// White Monte Carlo in a half-space (Kienle and Patterson 1996): photons that are never absorbed
// walk under Henyey-Greenstein scattering; where each leaves, the length of its path and its
// distance from the entry give the reflectance of every μa and σs' at every spatial frequency,
//
//     R(f) = Σ w e^(−a ℓ) J₀(k r),   a = μa/σs', k = 2πf/σs',   ℓ, r in units of 1/σs'.
//
// One walk serves several refractive indices: light meets the surface at one angle whatever the
// index, and leaves in part; the walk goes on with a weight for each index. Path lengths beyond
// 4, 16, 64, ... /σs' are followed by one photon in three with three times the weight.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace kappamu::forward {

struct LateralPoint {
  double a = 0.0;  ///< μa/σs', dimensionless, ≥ 0
  double k = 0.0;  ///< 2πf/σs', dimensionless, ≥ 0
};

struct WhiteReflectance {
  /// [index][point], light that leaves over light that enters; beam at normal incidence, all angles
  /// of exit.
  std::vector<double> value;
  std::vector<double> standard_error;  ///< [index][point], from the spread of the batches
};

struct WalkOptions {
  double anisotropy = 0.9;      ///< g, −1 < g < 1
  std::vector<double> indices;  ///< refractive indices relative to outside, each ≥ 1
  std::uint64_t photons = 1 << 20;
  int batches = 16;  ///< independent, ≥ 2; the result is the same on any number of threads
  std::uint64_t seed = 1;
};

WhiteReflectance walk_half_space(const WalkOptions& options, std::span<const LateralPoint> points);

}  // namespace kappamu::forward
