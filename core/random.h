// Counter-based random numbers: a value is a pure function of its key, so that results do not
// depend on how work is spread over threads. Mixing: SplitMix64 (Steele, Lea, Flood 2014).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace kappamu {

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

/// Point `index` of the low-discrepancy sequence R_d in [0, 1)^d, shifted at random by `key`
/// (M. Roberts 2018: multiples of powers of the root of x^(d+1) = x + 1; Cranley-Patterson shift).
template <std::size_t d>
std::array<double, d> low_discrepancy(std::uint64_t index, std::uint64_t key) {
  static const std::array<double, d> step = [] {
    double root = 1.5;
    for (int i = 0; i < 64; ++i) root = std::pow(1.0 + root, 1.0 / (d + 1.0));
    std::array<double, d> powers{};
    double power = 1.0;
    for (double& p : powers) p = power /= root;
    return powers;
  }();
  std::array<double, d> point{};
  for (std::size_t i = 0; i < d; ++i) {
    const double x = uniform(key_of({key, i})) + static_cast<double>(index) * step[i];
    point[i] = x - std::floor(x);
  }
  return point;
}

}  // namespace kappamu
