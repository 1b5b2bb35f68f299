// Noise of single pixels in a smooth picture (Immerkær 1996), and averages that lower it.
#pragma once

#include <cstdint>

#include "core/image.h"

namespace kappamu::calib {

/// Standard deviation of white noise at each pixel: root mean square, over 9 x 9 pixels, of the
/// second difference in both directions, which linear and quadratic structure leaves alone. 0 where
/// no pixel's neighbours are all valid.
Image<float> local_noise(const Image<float>& picture, const Image<std::uint8_t>& mask);

/// Mean of the valid pixels by a Gaussian of standard deviation `sigma` [px]; 0 where none is near.
Image<float> smoothed(const Image<float>& picture, const Image<std::uint8_t>& mask, double sigma);

}  // namespace kappamu::calib
