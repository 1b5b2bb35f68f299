#include "capture/session/bayer.h"

#include <cmath>

namespace kappamu::capture {

Image<std::uint16_t> pack_sites(const Image<std::uint16_t>& mosaic) {
  Image<std::uint16_t> packed(mosaic.width() / 2, mosaic.height() / 2, 4);
  for (int y = 0; y < 2 * packed.height(); ++y) {
    for (int x = 0; x < 2 * packed.width(); ++x) {
      packed(x / 2, y / 2, static_cast<int>(site_of(x, y))) = mosaic(x, y);
    }
  }
  return packed;
}

Image<std::uint16_t> pack_colours(const Image<std::uint16_t>& mosaic,
                                  const io::BayerLayout& layout) {
  Image<std::uint16_t> packed(mosaic.width() / 2, mosaic.height() / 2, bayer_colours);
  for (int y = 0; y < 2 * packed.height(); ++y) {
    for (int x = 0; x < 2 * packed.width(); ++x) {
      packed(x / 2, y / 2, layout[site_of(x, y)]) = mosaic(x, y);
    }
  }
  return packed;
}

Image<std::uint16_t> demosaic(const Image<std::uint16_t>& mosaic, const io::BayerLayout& layout) {
  Image<std::uint16_t> image(mosaic.width(), mosaic.height(), bayer_colours);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < bayer_colours; ++c) {
        float sum = 0.0F;
        for_each_source(x, y, image.width(), image.height(), layout, c,
                        [&](int u, int v, float weight) { sum += weight * mosaic(u, v); });
        image(x, y, c) = static_cast<std::uint16_t>(std::lround(sum));
      }
    }
  }
  return image;
}

}  // namespace kappamu::capture
