#include "capture/session/filled_border.h"

#include <algorithm>
#include <vector>

namespace kappamu::capture {

std::size_t saturate_filled_border(Image<std::uint16_t>& codes, int top) {
  const int margin = top / 100;
  const auto channels = static_cast<std::size_t>(codes.channels());
  const auto width = static_cast<std::size_t>(codes.width());
  const auto height = static_cast<std::size_t>(codes.height());
  std::uint16_t* values = codes.values().data();
  const auto filled = [&](std::size_t pixel) {
    const auto [least, most] =
        std::minmax_element(values + pixel * channels, values + (pixel + 1) * channels);
    return *least <= margin && *most >= top - margin;
  };
  std::vector<std::size_t> found;
  const auto visit = [&](std::size_t pixel) {
    if (!filled(pixel)) return;
    std::fill_n(values + pixel * channels, channels, static_cast<std::uint16_t>(top));
    found.push_back(pixel);
  };
  for (std::size_t x = 0; x < width; ++x) {
    visit(x);
    visit((height - 1) * width + x);
  }
  for (std::size_t y = 0; y < height; ++y) {
    visit(y * width);
    visit(y * width + width - 1);
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::size_t x = found[i] % width;
    const std::size_t y = found[i] / width;
    if (x > 0) visit(found[i] - 1);
    if (x + 1 < width) visit(found[i] + 1);
    if (y > 0) visit(found[i] - width);
    if (y + 1 < height) visit(found[i] + width);
  }
  return found.size();
}

}  // namespace kappamu::capture
