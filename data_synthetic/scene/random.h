// Normal and Poisson numbers by key (core/random.h).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "core/random.h"

namespace kappamu::synthetic {

/// Two independent standard normal numbers (Box-Muller).
struct NormalPair {
  double first = 0.0;
  double second = 0.0;
};
inline constexpr std::uint64_t second_of_pair = 0xD1B54A32D192ED03ULL;
inline NormalPair normal_pair(std::uint64_t key) {
  const double radius = std::sqrt(-2.0 * std::log(uniform(key)));
  const double angle = 2.0 * std::numbers::pi * uniform(key ^ second_of_pair);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

inline constexpr std::size_t most_counted = 256;
inline constexpr std::array<double, most_counted + 1> reciprocals = [] {
  std::array<double, most_counted + 1> all{};
  for (std::size_t n = 1; n < all.size(); ++n) all[n] = 1.0 / static_cast<double>(n);
  return all;
}();

/// Poisson number of the given mean: by inversion where it is small, the normal limit above 64
/// (there the third moment errs by less than 13 % of the standard deviation).
inline constexpr double poisson_is_normal = 64.0;
inline constexpr std::uint64_t of_poisson = 0x8CB92BA72F3D8DD7ULL;
inline double poisson(double mean, std::uint64_t key, double standard_normal) {
  if (mean <= 0.0) return 0.0;
  if (mean > poisson_is_normal) return std::round(mean + std::sqrt(mean) * standard_normal);
  double remaining = uniform(key ^ of_poisson);
  double probability = std::exp(-mean);
  // The tail beyond 256 has a probability below 1e-60 at the largest mean.
  std::size_t count = 0;
  while (remaining > probability && count < most_counted) {
    remaining -= probability;
    ++count;
    probability *= mean * reciprocals[count];  // a division a step would take most of the time
  }
  return static_cast<double>(count);
}

}  // namespace kappamu::synthetic
