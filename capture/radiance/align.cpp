#include "capture/radiance/align.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace kappamu::capture {
namespace {

template <class Value>
void move_back_by(const std::array<double, 2>& shift, Value saturated_from, Image<Value>& pixels) {
  const Image<Value> from = pixels;
  const std::array<int, 2> last{from.width() - 1, from.height() - 1};
  const std::array<int, 2> whole{static_cast<int>(std::floor(shift[0])),
                                 static_cast<int>(std::floor(shift[1]))};
  const double right = shift[0] - whole[0], below = shift[1] - whole[1];
  const std::array<double, 4> weights{(1 - right) * (1 - below), right * (1 - below),
                                      (1 - right) * below, right * below};
  for (int y = 0; y <= last[1]; ++y) {
    for (int x = 0; x <= last[0]; ++x) {
      for (int c = 0; c < from.channels(); ++c) {
        double sum = 0.0;
        Value largest{};
        for (int corner = 0; corner < 4; ++corner) {
          const double weight = weights[static_cast<std::size_t>(corner)];
          if (weight == 0.0) continue;
          const Value value = from(std::clamp(x + whole[0] + corner % 2, 0, last[0]),
                                   std::clamp(y + whole[1] + corner / 2, 0, last[1]), c);
          sum += weight * static_cast<double>(value);
          largest = std::max(largest, value);
        }
        if constexpr (std::is_integral_v<Value>) sum = std::round(sum);
        pixels(x, y, c) = largest >= saturated_from ? largest : static_cast<Value>(sum);
      }
    }
  }
}

}  // namespace

void move_back(const std::array<double, 2>& shift_px, int saturated_from, ExposedFrame& frame) {
  move_back_by(shift_px, static_cast<std::uint16_t>(saturated_from), frame.pixels);
}

void move_back(const std::array<double, 2>& shift_px, float saturated_from,
               ExposedFloatFrame& frame) {
  move_back_by(shift_px, saturated_from, frame.pixels);
}

void flag_unseen(const std::array<double, 2>& shift_px, HdrImage& image) {
  const int width = image.flags.width(), height = image.flags.height();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double from_x = x + shift_px[0], from_y = y + shift_px[1];
      if (from_x >= 0.0 && from_x <= width - 1 && from_y >= 0.0 && from_y <= height - 1) continue;
      for (int c = 0; c < image.flags.channels(); ++c) image.flags(x, y, c) |= pixel_missing;
    }
  }
}

}  // namespace kappamu::capture
