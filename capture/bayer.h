// Camera RAW in the Bayer domain: stacks are merged site by site, as the sensor saw them, and only
// the finished radiance is demosaiced.
#pragma once

#include <cstdint>

#include "capture/hdr.h"
#include "capture/radiometry.h"
#include "core/image.h"
#include "io/raw_file.h"

namespace kappamu::capture {

/// The four sites of each 2 x 2 cell as four channels of half the extent, index as in BayerLayout.
Image<std::uint16_t> pack_sites(const Image<std::uint16_t>& mosaic);

/// Half the extent, channels R, one G, B: untouched codes, for statistics of the noise.
Image<std::uint16_t> pack_colours(const Image<std::uint16_t>& mosaic,
                                  const io::BayerLayout& layout);

/// Bilinear demosaic of linear codes, rounded: full extent, channels R, G, B. A site keeps its own
/// code.
Image<std::uint16_t> demosaic(const Image<std::uint16_t>& mosaic, const io::BayerLayout& layout);

/// Radiometry of the four packed channels from that of R, G, B.
Radiometry site_radiometry(const Radiometry& radiometry, const io::BayerLayout& layout);

/// Bilinear demosaic of a packed merge: variances by the squared weights (neighbours then share
/// noise), saturated where any contributing site is, dark where all are.
HdrImage demosaic(const HdrImage& packed, const io::BayerLayout& layout);

}  // namespace kappamu::capture
