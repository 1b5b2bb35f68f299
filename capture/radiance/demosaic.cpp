#include "capture/radiance/demosaic.h"

#include <array>
#include <cstddef>

#include "capture/session/bayer.h"
#include "core/parallel.h"

namespace kappamu::capture {

namespace {

constexpr std::size_t sites_in_cell = 4;

/// Where a pixel's colour comes from: values of the packed picture, which has four a cell.
struct Sources {
  std::array<std::ptrdiff_t, 4> at{};
  int count = 0;
  float weight = 0.0F;

  void add(std::ptrdiff_t place, float weight_of_each) {
    at[static_cast<std::size_t>(count++)] = place;
    weight = weight_of_each;
  }
};

/// Of pixel (x, y) in a picture of that size; `place(cell x, cell y, site)` is an index.
template <class Place>
Sources sources_of(int x, int y, int width, int height, const io::BayerLayout& layout, int colour,
                   const Place& place) {
  Sources sources;
  for_each_source(x, y, width, height, layout, colour, [&](int u, int v, float weight) {
    sources.add(place(u / 2, v / 2, static_cast<std::ptrdiff_t>(site_of(u, v))), weight);
  });
  return sources;
}

}  // namespace

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
  const int columns = packed.radiance.width();
  const int width = 2 * columns, height = 2 * packed.radiance.height();
  HdrImage out{Image<float>(width, height, bayer_colours),
               Image<float>(width, height, bayer_colours),
               Image<std::uint8_t>(width, height, bayer_colours)};
  const auto index = [columns](int u, int v, std::ptrdiff_t site) {
    return (static_cast<std::ptrdiff_t>(v) * columns + u) * std::ptrdiff_t{sites_in_cell} + site;
  };
  // Inside, the sources of a site's colours lie the same from its cell.
  std::array<std::array<Sources, bayer_colours>, sites_in_cell> inside;
  constexpr int cells = 3, middle = 1;
  for (int site = 0; site < static_cast<int>(sites_in_cell); ++site) {
    for (int c = 0; c < bayer_colours; ++c) {
      inside[static_cast<std::size_t>(site)][static_cast<std::size_t>(c)] =
          sources_of(2 * middle + site % 2, 2 * middle + site / 2, 2 * cells, 2 * cells, layout, c,
                     [&](int u, int v, std::ptrdiff_t of_site) {
                       return index(u - middle, v - middle, of_site);
                     });
    }
  }
  for_rows(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const bool rim = x == 0 || y == 0 || x == width - 1 || y == height - 1;
      const std::ptrdiff_t cell = rim ? 0 : index(x / 2, y / 2, 0);
      for (int c = 0; c < bayer_colours; ++c) {
        Sources of_rim;
        if (rim) of_rim = sources_of(x, y, width, height, layout, c, index);
        const Sources& sources = rim ? of_rim : inside[site_of(x, y)][static_cast<std::size_t>(c)];
        float radiance = 0.0F;
        float variance = 0.0F;
        std::uint8_t any = pixel_ok;
        std::uint8_t all = pixel_dark;
        for (int k = 0; k < sources.count; ++k) {
          const auto at = static_cast<std::size_t>(cell + sources.at[static_cast<std::size_t>(k)]);
          radiance += sources.weight * packed.radiance.values()[at];
          variance += sources.weight * sources.weight * packed.variance.values()[at];
          any |= packed.flags.values()[at];
          all &= packed.flags.values()[at];
        }
        out.radiance(x, y, c) = radiance;
        out.variance(x, y, c) = variance;
        out.flags(x, y, c) = static_cast<std::uint8_t>((any & ~pixel_dark) | all);
      }
    }
  });
  return out;
}

}  // namespace kappamu::capture
