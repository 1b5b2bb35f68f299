// Camera RAW is merged site by site, as the sensor saw it; only the finished radiance is
// demosaiced.
#pragma once

#include "capture/radiance/hdr.h"
#include "capture/response/radiometry.h"
#include "io/image/raw_file.h"

namespace kappamu::capture {

/// Radiometry of the four packed channels from that of R, G, B.
Radiometry site_radiometry(const Radiometry& radiometry, const io::BayerLayout& layout);

/// Bilinear demosaic of a packed merge: variances by the squared weights (neighbours then share
/// noise), saturated where any contributing site is, dark where all are.
HdrImage demosaic(const HdrImage& packed, const io::BayerLayout& layout);

}  // namespace kappamu::capture
