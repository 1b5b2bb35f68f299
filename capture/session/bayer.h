// Codes of camera RAW in the Bayer domain.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/image.h"
#include "io/image/raw_file.h"

namespace kappamu::capture {

/// The four sites of each 2 x 2 cell as four channels of half the extent, index as in BayerLayout.
Image<std::uint16_t> pack_sites(const Image<std::uint16_t>& mosaic);

/// Half the extent, channels R, one G, B: untouched codes, for statistics of the noise.
Image<std::uint16_t> pack_colours(const Image<std::uint16_t>& mosaic,
                                  const io::BayerLayout& layout);

/// Bilinear demosaic of linear codes, rounded: full extent, channels R, G, B. A site keeps its own
/// code.
Image<std::uint16_t> demosaic(const Image<std::uint16_t>& mosaic, const io::BayerLayout& layout);

inline constexpr int bayer_colours = 3;

/// Index of pixel (x, y) within its 2 x 2 cell, as in BayerLayout.
inline std::size_t site_of(int x, int y) {
  return static_cast<std::size_t>(2 * (y % 2) + x % 2);
}

/// Calls visit(x, y, weight) for the sites that give pixel (x, y) its `colour`: itself if it has
/// it, otherwise its neighbours of that colour, equally far ones with equal weight. Weights sum
/// to 1.
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

}  // namespace kappamu::capture
