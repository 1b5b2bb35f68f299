// Normal and Poisson numbers by key (core/random.h).
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/random.h"

namespace kappamu::synthetic {

/// Two independent standard normal numbers (Box-Muller).
struct NormalPair {
  double first = 0.0;
  double second = 0.0;
};
inline NormalPair normal_pair(std::uint64_t key) {
  const double radius = std::sqrt(-2.0 * std::log(uniform(key)));
  const double angle = 2.0 * std::numbers::pi * uniform(key ^ 0xD1B54A32D192ED03ULL);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// Poisson number of the given mean: by inversion where it is small, the normal limit above 64
/// (there the third moment errs by less than 13 % of the standard deviation).
inline double poisson(double mean, std::uint64_t key, double standard_normal) {
  if (mean <= 0.0) return 0.0;
  if (mean > 64.0) return std::round(mean + std::sqrt(mean) * standard_normal);
  double remaining = uniform(key ^ 0x8CB92BA72F3D8DD7ULL);
  double probability = std::exp(-mean);
  double count = 0.0;
  // The tail beyond 256 has a probability below 1e-60 at the largest mean.
  while (remaining > probability && count < 256.0) {
    remaining -= probability;
    count += 1.0;
    probability *= mean / count;
  }
  return count;
}

}  // namespace kappamu::synthetic
