// HDR merge: the frames of a stack become linear radiance with a variance and flags per pixel.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "capture/hdr.h"
#include "capture/radiometry.h"
#include "capture/response.h"
#include "capture/session.h"

namespace kappamu::capture {

enum class MergeWeight {
  inverse_variance,  ///< shot, read and quantisation noise at the merged estimate: the default
  debevec_hat        ///< Debevec & Malik 1997, eq. (4) and (6): baseline
};

struct MergeOptions {
  MergeWeight weight = MergeWeight::inverse_variance;
  /// Whether a stack without any pixel above the noise is an error (it is not for black frames).
  bool require_light = true;
};

/// Radiance in full scales per second. Unbiased in the dark: black-subtracted values keep their
/// sign and no weight depends on a pixel's own noisy code. Where a pixel is flagged
/// pixel_saturated its radiance is a lower bound and its variance that bound squared; where it is
/// flagged pixel_dark radiance and variance hold. `name` begins an error's sentence ("session.json:
/// pattern fit_03"). Throws InputError if every pixel is saturated in every frame, or dark.
HdrImage merge_frames(std::span<const ExposedFrame> frames, const Radiometry& radiometry,
                      const std::string& name, const MergeOptions& options = {});

/// The same from linear images (EXR), fractions of full scale, saturated from 1 on.
struct ExposedFloatFrame {
  Image<float> linear;
  double exposure_s = 0.0;
};
HdrImage merge_float_frames(std::span<const ExposedFloatFrame> frames, const Radiometry& radiometry,
                            const std::string& name, const MergeOptions& options = {});

/// Loads and merges the frames of one stack; holds one stack at a time. `label` names it in
/// errors ("pattern fit_03").
HdrImage merge_stack(const Session& session, const Stack& stack, const std::string& label,
                     const Radiometry& radiometry, const MergeOptions& options = {});

}  // namespace kappamu::capture
