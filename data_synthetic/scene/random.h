// Counter-based random numbers: a value is a pure function of its key, so that results do not
// depend on how work is spread over threads. Mixing: SplitMix64 (Steele, Lea, Flood 2014).
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>

namespace kappamu::synthetic {

/// One step of SplitMix64: a bijection on 64 bits whose output passes for random.
inline std::uint64_t mix(std::uint64_t value) {
  value += 0x9E3779B97F4A7C15ULL;
  value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9ULL;
  value = (value ^ (value >> 27)) * 0x94D049BB133111EBULL;
  return value ^ (value >> 31);
}

/// Key of a tuple of counters; differs for every order of its parts.
inline std::uint64_t key_of(std::initializer_list<std::uint64_t> parts) {
  std::uint64_t key = 0;
  for (const std::uint64_t part : parts) key = mix(key ^ mix(part));
  return key;
}

/// Uniform in (0, 1), never 0.
inline double uniform(std::uint64_t key) {
  return (static_cast<double>(mix(key) >> 11) + 0.5) * 0x1p-53;
}

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
/// (there the third moment is off by less than 13 % of the standard deviation).
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
