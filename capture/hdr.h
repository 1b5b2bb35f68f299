// High dynamic range merge: a stack of frames becomes linear radiance with variance and validity.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capture/session.h"
#include "core/image.h"

namespace kappamu::capture {

/// Inverse response of the camera per channel: linear signal as a fraction of full scale for each
/// code value.
struct Response {
  /// [channel][code], codes 0 ... 2^bits - 1; rising, 0 at the black level, 1 at the largest code.
  std::vector<std::vector<double>> linear;
};

/// Why a pixel cannot be trusted; bits of HdrImage::flags.
enum PixelFlag : std::uint8_t {
  pixel_ok = 0,
  pixel_saturated = 1,  ///< saturated in every frame: radiance is a lower bound
  pixel_dark = 2,       ///< below the noise in every frame
  pixel_missing = 4     ///< no frame
};

struct HdrImage {
  Image<float>
      radiance;  ///< [y][x][channel], in full scales per second: linear signal / exposure time
  Image<float> variance;      ///< variance of radiance
  Image<std::uint8_t> flags;  ///< [y][x][channel], PixelFlag bits
};

}  // namespace kappamu::capture
