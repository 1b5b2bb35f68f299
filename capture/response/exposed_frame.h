// Frames in memory, with the exposure time that goes with each.
#pragma once

#include <cstdint>

#include "core/image.h"

namespace kappamu::capture {

template <class Value>
struct Exposed {
  Image<Value> pixels;  ///< [y][x][channel]
  double exposure_s = 0.0;
};
/// Code values.
using ExposedFrame = Exposed<std::uint16_t>;
/// Linear light (EXR), fractions of full scale, saturated from 1 on.
using ExposedFloatFrame = Exposed<float>;

}  // namespace kappamu::capture
