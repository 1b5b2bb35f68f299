// Frames in memory, with the exposure time that goes with each.
#pragma once

#include <cstdint>

#include "core/image.h"

namespace kappamu::capture {

/// Code values [y][x][channel].
struct ExposedFrame {
  Image<std::uint16_t> codes;
  double exposure_s = 0.0;
};

/// Linear light (EXR) [y][x][channel], fractions of full scale, saturated from 1 on.
struct ExposedFloatFrame {
  Image<float> linear;
  double exposure_s = 0.0;
};

}  // namespace kappamu::capture
