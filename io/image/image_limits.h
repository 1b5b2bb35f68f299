// How much memory a picture may ask for: the one place of these limits. What a header claims is
// compared with what its reader expects, or else with a stated limit, before anything makes room
// for the pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>

namespace kappamu::io {

/// [bytes]; 16-bit RGB without compression up to 178 megapixels, a merged picture up to 29.
constexpr std::size_t largest_image_file = std::size_t{1} << 30;
/// Width times height times channels of a picture of which nothing is expected: 600 MB of codes,
/// 100 megapixels in colour.
constexpr std::uint64_t most_image_values = 300'000'000;

struct ImageSize {
  int width = 0;     ///< [px]
  int height = 0;    ///< [px]
  int channels = 0;  ///< without alpha
  int bits = 0;      ///< of a stored code; 0: unknown, or floats
};

/// What the caller of a reader expects: throws InputError naming the file where `claimed` is
/// something else. Empty where nothing is expected.
using SizeCheck = std::function<void(const ImageSize& claimed)>;

/// Asks `expected`, or holds the claim against most_image_values. Then throws InputError naming the
/// file where so few `bytes` cannot hold a picture of that size, whoever expects it.
void check_size(const std::filesystem::path& file, const ImageSize& claimed, std::size_t bytes,
                const SizeCheck& expected);

}  // namespace kappamu::io
