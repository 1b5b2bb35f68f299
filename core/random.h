// Counter-based random numbers: a value is a pure function of its key, so that results do not
// depend on how work is spread over threads. Mixing: SplitMix64 (Steele, Lea, Flood 2014).
#pragma once

#include <array>
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

/// `bits` with the order of its digits turned round.
inline std::uint32_t reversed_bits(std::uint32_t bits) {
  bits = (bits >> 16) | (bits << 16);
  bits = ((bits & 0xFF00FF00U) >> 8) | ((bits & 0x00FF00FFU) << 8);
  bits = ((bits & 0xF0F0F0F0U) >> 4) | ((bits & 0x0F0F0F0FU) << 4);
  bits = ((bits & 0xCCCCCCCCU) >> 2) | ((bits & 0x33333333U) << 2);
  return ((bits & 0xAAAAAAAAU) >> 1) | ((bits & 0x55555555U) << 1);
}

/// Owen's nested scrambling of a binary fraction, by hash (B. Burley, Practical hash-based Owen
/// scrambling, JCGT 2020, after Laine and Karras 2011).
inline std::uint32_t owen_scrambled(std::uint32_t bits, std::uint32_t key) {
  bits = reversed_bits(bits) + key;
  for (const std::uint32_t factor : {0x6C50B47CU, 0xB82F1E52U, 0xC7AFE638U, 0x8D22F6E6U}) {
    bits ^= bits * factor;
  }
  return reversed_bits(bits);
}

/// Point `index` of Sobol's sequence in the plane, in [0, 1)², scrambled and shuffled by `key`
/// (Burley 2020): of low discrepancy over consecutive indices, unbiased over keys, and sequences of
/// different keys pair at random, so that an integral over more dimensions takes a key for every
/// two.
inline std::array<double, 2> sobol_point(std::uint32_t index, std::uint64_t key) {
  const std::uint64_t keys = mix(key), more = mix(keys);
  const std::uint32_t i = owen_scrambled(index, static_cast<std::uint32_t>(keys));
  // The second dimension's matrix is Pascal's triangle modulo 2: a product of five butterflies.
  std::uint32_t second = i;
  second ^= second >> 1 & 0x55555555U;
  second ^= second >> 2 & 0x33333333U;
  second ^= second >> 4 & 0x0F0F0F0FU;
  second ^= second >> 8 & 0x00FF00FFU;
  second ^= second >> 16;
  return {owen_scrambled(reversed_bits(i), static_cast<std::uint32_t>(keys >> 32)) * 0x1p-32,
          owen_scrambled(reversed_bits(second), static_cast<std::uint32_t>(more)) * 0x1p-32};
}

}  // namespace kappamu
