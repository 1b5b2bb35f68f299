#include "capture/radiance/demosaic.h"

#include "capture/session/bayer.h"

namespace kappamu::capture {

Radiometry site_radiometry(const Radiometry& radiometry, const io::BayerLayout& layout) {
  Radiometry sites;
  sites.bit_depth = radiometry.bit_depth;
  for (const int colour : layout) {
    const auto c = static_cast<std::size_t>(colour);
    sites.response.linear.push_back(radiometry.response.linear[c]);
    sites.black_level.push_back(radiometry.black_level[c]);
    sites.noise.push_back(radiometry.noise[c]);
  }
  return sites;
}

HdrImage demosaic(const HdrImage& packed, const io::BayerLayout& layout) {
  const int width = 2 * packed.radiance.width();
  const int height = 2 * packed.radiance.height();
  HdrImage out{Image<float>(width, height, bayer_colours),
               Image<float>(width, height, bayer_colours),
               Image<std::uint8_t>(width, height, bayer_colours)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < bayer_colours; ++c) {
        float radiance = 0.0F;
        float variance = 0.0F;
        std::uint8_t any = pixel_ok;
        std::uint8_t all = pixel_dark;
        for_each_source(x, y, width, height, layout, c, [&](int u, int v, float weight) {
          const int site = static_cast<int>(site_of(u, v));
          radiance += weight * packed.radiance(u / 2, v / 2, site);
          variance += weight * weight * packed.variance(u / 2, v / 2, site);
          any |= packed.flags(u / 2, v / 2, site);
          all &= packed.flags(u / 2, v / 2, site);
        });
        out.radiance(x, y, c) = radiance;
        out.variance(x, y, c) = variance;
        out.flags(x, y, c) = static_cast<std::uint8_t>((any & ~pixel_dark) | all);
      }
    }
  }
  return out;
}

}  // namespace kappamu::capture
