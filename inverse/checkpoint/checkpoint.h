// What makes a fit's state a checkpoint that can be trusted: 48 bytes before it, native byte order,
//
//   format "KMU-CKPT" | version | bytes of the state | inputs | program | checksum
//
// eight bytes each. The checksum is FNV-1a, 64 bit, over all bytes but its own: a change of a
// single byte always changes it, any other change but one time in 2⁶⁴.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kappamu::inverse {

/// What a checkpoint must not be mixed with.
struct CheckpointOrigin {
  std::uint64_t inputs = 0;   ///< fingerprint of measurements, options and context
  std::uint64_t program = 0;  ///< fingerprint of program, device and driver
};

std::vector<std::byte> seal(std::span<const std::byte> state, const CheckpointOrigin& origin);

/// The state within `bytes`. Throws InputError, which says why it cannot be used as the end of a
/// sentence "A checkpoint ...".
std::span<const std::byte> unseal(std::span<const std::byte> bytes, const CheckpointOrigin& origin);

}  // namespace kappamu::inverse
