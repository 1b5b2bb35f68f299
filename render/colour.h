// Light of three channels, R, G, B: linear, of sRGB's primaries where a display needs to know.
#pragma once

#include <Eigen/Core>

namespace kappamu::render {

using Colour = Eigen::Array3d;

/// Relative luminance (ITU-R BT.709).
inline double luminance(const Colour& colour) {
  return 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2];
}

}  // namespace kappamu::render
