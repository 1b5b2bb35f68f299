#include "calib/projector/gray_code.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::calib {
namespace {

constexpr double least_white = 0.04;  // above black, of the brightest pixel
constexpr double least_bit = 0.02;    // between a bit and its inverse

int bits_of(int extent) {
  return static_cast<int>(std::bit_width(static_cast<unsigned>(extent - 1)));
}

/// Frames n and n + 1, decoded at the same time.
std::array<Image<float>, 2> pair_from(const FrameSource& frames, std::size_t n) {
  std::array<Image<float>, 2> pair;
  for_rows(2, [&](int k) {
    pair[static_cast<std::size_t>(k)] = frames(n + static_cast<std::size_t>(k));
  });
  return pair;
}

}  // namespace

ProjectorMap decode_gray_code(const FrameSource& frames, const capture::Projector& projector) {
  const auto count = static_cast<std::size_t>(capture::gray_code_frames(projector));
  const auto [white, black] = pair_from(frames, count - 2);
  const float brightest = *std::max_element(white.values().begin(), white.values().end());
  const std::array<int, 2> extent{projector.width, projector.height};
  ProjectorMap map{Image<float>(white.width(), white.height(), 2),
                   Image<float>(white.width(), white.height(), 1)};
  const auto range_of = [&white = white, &black = black](std::size_t k) {
    return static_cast<double>(white.values()[k]) - black.values()[k];
  };
  const auto seen = [&](std::size_t k) { return range_of(k) >= least_white * brightest; };
  for (std::size_t k = 0; k < map.quality.size(); ++k) {
    map.quality.values()[k] = seen(k) ? 1.0F : 0.0F;
  }
  std::size_t frame = 0;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    for (int b = bits_of(extent[axis]); b > 0; --b, frame += 2) {
      const auto [lit, inverse] = pair_from(frames, frame);
      check(lit.same_shape(white) && inverse.same_shape(white),
            "the frames of a Gray code are of one size");
      const auto decode = [&, &bright = lit, &dark = inverse](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          if (!seen(k)) continue;
          const double difference = static_cast<double>(bright.values()[k]) - dark.values()[k];
          const bool legible = std::abs(difference) >= least_bit * brightest;
          float& code = map.pixel.values()[2 * k + axis];
          if (b == 1 && !legible) {
            code = 2.0F * code + 0.5F;  // between the two pixels that only this bit tells apart
            continue;
          }
          float& weakest = map.quality.values()[k];
          weakest = std::min(
              weakest, legible ? static_cast<float>(std::abs(difference) / range_of(k)) : 0.0F);
          // Gray: each bit turns the one above it, the last of what was read.
          const bool above = static_cast<unsigned>(code) % 2 == 1;
          code = 2.0F * code + (above != (difference > 0.0) ? 1.0F : 0.0F);
        }
      };
      for_ranges(map.quality.size(), decode);
    }
    for (std::size_t k = 0; k < map.quality.size(); ++k) {
      if (map.pixel.values()[2 * k + axis] >= static_cast<float>(extent[axis])) {
        map.quality.values()[k] = 0.0F;
      }
    }
  }
  return map;
}

}  // namespace kappamu::calib
