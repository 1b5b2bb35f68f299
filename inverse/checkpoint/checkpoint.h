// What makes a fit's state a checkpoint that can be trusted: 40 bytes before it, native byte order,
//
//   format "KMU-CKPT" | version | bytes of the state | origin | checksum
//
// eight bytes each. The checksum is FNV-1a, 64 bit, over all bytes but its own: a change of a
// single byte always changes it, any other change but one time in 2⁶⁴.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kappamu::inverse {

/// `origin` identifies the fit: fingerprint().
std::vector<std::byte> seal(std::span<const std::byte> state, std::uint64_t origin);

/// The state within `bytes`. Throws InputError with the reason, as the end of a sentence
/// "A checkpoint ...".
std::span<const std::byte> unseal(std::span<const std::byte> bytes, std::uint64_t origin);

}  // namespace kappamu::inverse
