#include "calib/projector/gray_code.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/error.h"

namespace kappamu::calib {
namespace {

constexpr double least_white = 0.04;  // above black, of the brightest pixel
constexpr double least_bit = 0.02;    // between a bit and its inverse

int bits_of(int extent) {
  return static_cast<int>(std::bit_width(static_cast<unsigned>(extent - 1)));
}

}  // namespace

ProjectorMap decode_gray_code(const std::vector<Image<float>>& frames,
                              const capture::Projector& projector) {
  check(frames.size() == static_cast<std::size_t>(capture::gray_code_frames(projector)),
        "decode_gray_code wants as many frames as the projector's code has");
  const Image<float>& white = frames[frames.size() - 2];
  const Image<float>& black = frames[frames.size() - 1];
  const float brightest = *std::max_element(white.values().begin(), white.values().end());
  const std::array<int, 2> extent{projector.width, projector.height};
  ProjectorMap map{Image<float>(white.width(), white.height(), 2),
                   Image<float>(white.width(), white.height(), 1)};
  for (std::size_t k = 0; k < white.size(); ++k) {
    const double range = static_cast<double>(white.values()[k]) - black.values()[k];
    if (range < least_white * brightest) continue;
    double weakest = 1.0;
    bool inside = true;
    std::size_t frame = 0;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      double code = 0.0;
      bool bit = false;  // Gray: each bit turns the one above it
      for (int b = bits_of(extent[axis]); b > 0; --b, frame += 2) {
        const double difference =
            static_cast<double>(frames[frame].values()[k]) - frames[frame + 1].values()[k];
        const bool legible = std::abs(difference) >= least_bit * brightest;
        if (b == 1 && !legible) {
          code = 2.0 * code + 0.5;  // between the two pixels that only this bit tells apart
          continue;
        }
        weakest = std::min(weakest, legible ? std::abs(difference) / range : 0.0);
        bit = bit != (difference > 0.0);
        code = 2.0 * code + (bit ? 1.0 : 0.0);
      }
      inside = inside && code < extent[axis];
      map.pixel.values()[2 * k + axis] = static_cast<float>(code);
    }
    if (inside) map.quality.values()[k] = static_cast<float>(weakest);
  }
  return map;
}

}  // namespace kappamu::calib
