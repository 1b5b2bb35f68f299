// High dynamic range merge: a stack of frames becomes linear radiance with variance and validity.
#pragma once

#include <cstdint>

#include "core/image.h"
#include "core/numbers/region.h"

namespace kappamu::capture {

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
  int left = 0, top = 0;  ///< [px] of its first pixel in the camera's picture, where it is a part

  Region place() const { return {left, top, radiance.width(), radiance.height()}; }
};

}  // namespace kappamu::capture
