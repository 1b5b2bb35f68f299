// Black level and read noise from frames with the lens covered.
#pragma once

#include <vector>

#include "capture/session/session.h"

namespace kappamu::capture {

/// One channel of the dark frames.
struct DarkLevel {
  double code = 0.0;       ///< black level: robust mean of the codes
  double deviation = 0.0;  ///< their standard deviation, rounding included [codes]
};

/// Dark level of a histogram of codes [code] -> count. Codes far from the bulk (hot pixels) are
/// left out. Where more than a sixth of the pixels sit at code 0 the camera has cut the noise off
/// below; then the median is the level and the deviation is that above it.
DarkLevel dark_level(const std::vector<long>& histogram);

/// [channel] of the session's dark frames; loads one frame at a time. EXR values are counted in
/// codes of the session's bit depth.
std::vector<DarkLevel> dark_levels(const Session& session);

/// [channel] without dark frames, from one stack. Linear: where the codes z of shortest and longest
/// exposure t meet at t = 0, (z₁ t₂ - z₂ t₁)/(t₂ - t₁), median over the darkest tenth of the pixels
/// that saturate in neither. An unknown response: the shortest frame's median code at the hundredth
/// of the pixels that are darkest in the longest, where the times span a factor of 100; else the
/// code that a thousandth of the shortest frame lies below. Either is 0 for most files and a
/// pedestal where there is one.
std::vector<DarkLevel> dark_levels_of_stack(const Session& session, const Stack& stack);

}  // namespace kappamu::capture
