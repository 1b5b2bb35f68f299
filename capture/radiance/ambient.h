// Light that does not come from the projector: photographs with the projector off, taken off those
// with it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/radiance/hdr.h"
#include "capture/radiance/merge.h"
#include "capture/response/radiometry.h"
#include "capture/session/session.h"

namespace kappamu::capture {

/// Takes the light of `off` off `picture`, two pictures of one scene: variances add, and a pixel
/// that is unusable in one is so in the result.
void take_off(const HdrImage& off, HdrImage& picture);

/// The room's light on the sample, from Calibration::ambient.
struct AmbientLight {
  /// Mean over the times it was photographed; its variance includes the square of half the range,
  /// since nobody knows when the light changed.
  HdrImage mean;
  double total = 0.0;       ///< sum of `mean` over the picture [full scales per second]
  double half_range = 0.0;  ///< the same of half the difference between brightest and darkest time
};

/// Nothing for a session without `ambient`. Frames that were corrected are added to `notes`.
std::optional<AmbientLight> merge_ambient(const Session& session, const Radiometry& radiometry,
                                          const MergeOptions& options,
                                          std::vector<std::string>* notes = nullptr);

/// Sum of a picture's usable radiance [full scales per second].
double total_light(const HdrImage& picture);

}  // namespace kappamu::capture
