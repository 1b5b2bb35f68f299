// Philox4x32-10 (Salmon et al. 2011): random numbers as a function of a key and a counter, on the
// host what photon_tracer.cl draws on a device.
#pragma once

#include <array>
#include <cstdint>

namespace kappamu::forward {

using PhiloxBlock = std::array<std::uint32_t, 4>;
using PhiloxKey = std::array<std::uint32_t, 2>;

inline PhiloxBlock philox(PhiloxBlock counter, PhiloxKey key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p = std::uint64_t{counter[0]} * 0xD2511F53U;
    const std::uint64_t q = std::uint64_t{counter[2]} * 0xCD9E8D57U;
    counter = {
        static_cast<std::uint32_t>(q >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(q),
        static_cast<std::uint32_t>(p >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(p)};
    key[0] += 0x9E3779B9U;
    key[1] += 0xBB67AE85U;
  }
  return counter;
}

/// In (0, 1): the middle of the bits' interval.
inline double uniform_of(std::uint32_t bits) {
  return (static_cast<double>(bits) + 0.5) * 0x1p-32;
}

}  // namespace kappamu::forward
