// Errors of equal size in every octave of spatial frequency, as waves of an image.
#pragma once

#include <numbers>

namespace kappamu {

/// 2 π f df cosines for each pixel lie between frequencies f and f + df [1/pixel]. Where the
/// variance of each is 1 over this, the cosines of every octave have variance 1 in sum.
constexpr double octave_waves(double frequency_squared) {
  return 2.0 * std::numbers::pi * std::numbers::ln2 * frequency_squared;
}

}  // namespace kappamu
