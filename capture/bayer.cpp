#include "capture/bayer.h"

#include <algorithm>
#include <cmath>

namespace kappamu::capture {
namespace {

constexpr int colours = 3;

std::size_t site_of(int x, int y) {
  return static_cast<std::size_t>(2 * (y % 2) + x % 2);
}

// Calls visit(x, y, weight) for the sites that give pixel (x, y) its `colour`: itself if it has it,
// otherwise its neighbours of that colour, equally far ones with equal weight. Weights sum to 1.
template <class Visit>
void for_each_source(int x, int y, int width, int height, const io::BayerLayout& layout, int colour,
                     const Visit& visit) {
  if (layout[site_of(x, y)] == colour) return visit(x, y, 1.0F);
  int count = 0;
  for (const bool counting : {true, false}) {
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v) {
      for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u) {
        if (layout[site_of(u, v)] != colour) continue;
        if (counting) {
          ++count;
        } else {
          visit(u, v, 1.0F / static_cast<float>(count));
        }
      }
    }
  }
}

}  // namespace

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
  Image<std::uint16_t> packed(mosaic.width() / 2, mosaic.height() / 2, colours);
  for (int y = 0; y < 2 * packed.height(); ++y) {
    for (int x = 0; x < 2 * packed.width(); ++x) {
      packed(x / 2, y / 2, layout[site_of(x, y)]) = mosaic(x, y);
    }
  }
  return packed;
}

Image<std::uint16_t> demosaic(const Image<std::uint16_t>& mosaic, const io::BayerLayout& layout) {
  Image<std::uint16_t> image(mosaic.width(), mosaic.height(), colours);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < colours; ++c) {
        float sum = 0.0F;
        for_each_source(x, y, image.width(), image.height(), layout, c,
                        [&](int u, int v, float weight) { sum += weight * mosaic(u, v); });
        image(x, y, c) = static_cast<std::uint16_t>(std::lround(sum));
      }
    }
  }
  return image;
}

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
  HdrImage out{Image<float>(width, height, colours), Image<float>(width, height, colours),
               Image<std::uint8_t>(width, height, colours)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < colours; ++c) {
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
