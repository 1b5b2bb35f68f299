#include "capture/session/filled_border.h"

#include <algorithm>
#include <vector>

namespace kappamu::capture {

bool is_filled(const std::uint16_t* pixel, std::size_t channels, int top) {
  const int margin = top / 100;
  const auto [least, most] = std::minmax_element(pixel, pixel + channels);
  return *least <= margin && *most >= top - margin;
}

std::size_t saturate_filled_border(Image<std::uint16_t>& codes, int top) {
  const auto channels = static_cast<std::size_t>(codes.channels());
  const auto width = static_cast<std::size_t>(codes.width());
  const auto height = static_cast<std::size_t>(codes.height());
  std::uint16_t* values = codes.values().data();
  const auto filled = [&](std::size_t pixel) {
    return is_filled(values + pixel * channels, channels, top);
  };
  std::vector<std::uint8_t> seen(width * height, 0);
  std::vector<std::size_t> region;
  const auto visit = [&](std::size_t pixel) {
    if (seen[pixel] != 0 || !filled(pixel)) return;
    seen[pixel] = 1;
    region.push_back(pixel);
  };
  std::size_t count = 0;
  const auto saturate_region = [&](std::size_t start) {
    region.clear();
    visit(start);
    for (std::size_t i = 0; i < region.size(); ++i) {
      const std::size_t x = region[i] % width;
      const std::size_t y = region[i] / width;
      if (x > 0) visit(region[i] - 1);
      if (x + 1 < width) visit(region[i] + 1);
      if (y > 0) visit(region[i] - width);
      if (y + 1 < height) visit(region[i] + width);
    }
    if (2 * region.size() < std::min(width, height)) return;
    for (const std::size_t pixel : region) {
      std::fill_n(values + pixel * channels, channels, static_cast<std::uint16_t>(top));
    }
    count += region.size();
  };
  for (std::size_t x = 0; x < width; ++x) {
    saturate_region(x);
    saturate_region((height - 1) * width + x);
  }
  for (std::size_t y = 0; y < height; ++y) {
    saturate_region(y * width);
    saturate_region(y * width + width - 1);
  }
  return count;
}

}  // namespace kappamu::capture
