// Camera RAW files (DNG, CR2 and whatever else LibRaw reads): the sensor's own codes, unprocessed.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include "core/image.h"

namespace kappamu::io {

/// Whether the name ends like a camera RAW file (.dng, .cr2, .nef, .arw, ...).
bool is_raw_file(const std::filesystem::path& file);

/// Colours of a Bayer sensor's sites: index 2 * (y % 2) + x % 2, value 0 = R, 1 = G, 2 = B.
using BayerLayout = std::array<int, 4>;

struct RawImage {
  /// Codes of the visible area as the sensor gave them, one channel, both extents even: no black
  /// subtracted, no white balance, no demosaicing.
  Image<std::uint16_t> mosaic;
  BayerLayout layout{};
  std::array<double, 3> black{};  ///< R, G, B black level as the file tells it [codes]
  int white = 0;                  ///< code at which the sensor saturates, as the file tells it
};

/// Throws InputError naming the file if it is missing, truncated, unknown to LibRaw, or not from a
/// Bayer sensor.
RawImage read_raw(const std::filesystem::path& file);

}  // namespace kappamu::io
