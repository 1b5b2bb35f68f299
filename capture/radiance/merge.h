// HDR merge: the frames of a stack become linear radiance with a variance and flags per pixel.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "capture/radiance/hdr.h"
#include "capture/radiance/steadiness.h"
#include "capture/response/exposed_frame.h"
#include "capture/response/radiometry.h"
#include "capture/session/frames.h"
#include "capture/session/session.h"

namespace kappamu::capture {

/// What to do about frames that do not fit the rest of their stack (capture/radiance/steadiness.h).
enum class OnFault { refuse, correct, ignore, align };

struct MergeOptions {
  /// Whether a stack without any pixel above the noise is an error (it is not for black frames).
  bool require_light = true;
  /// merge_stack() only: flicker, drift and mislabelled exposures. Corrected, exposure times are
  /// estimated from the frames; the stack's mean brightness is kept.
  OnFault on_flicker = OnFault::refuse;
  /// merge_stack() only: frames shifted or partly changed. Corrected, they are left out. Aligned,
  /// shifted ones are moved back (capture/radiance/align.h), pixels that one of them did not see
  /// are flagged missing, and what differs after that is refused.
  OnFault on_motion = OnFault::refuse;
  /// merge_stack() only: the part of the picture that is read, compared and merged, its edges on
  /// multiples of merged_grid_px or the picture's own.
  Part part{};
};

/// Blocks of capture/radiance/steadiness.h, of each of a mosaic's four kinds of site, lie the same
/// in a part as in the whole.
inline constexpr int merged_grid_px = 8;

/// Radiance in full scales per second. Unbiased in the dark: black-subtracted values keep their
/// sign and no weight depends on a pixel's own noisy code. Where a pixel is flagged
/// pixel_saturated its radiance is a lower bound and its variance that bound squared; where it is
/// flagged pixel_dark radiance and variance hold. `name` begins an error's sentence ("session.json:
/// pattern fit_03"). Throws InputError if every pixel is saturated in every frame, or dark.
HdrImage merge_frames(std::span<const ExposedFrame> frames, const Radiometry& radiometry,
                      const std::string& name, const MergeOptions& options = {});
HdrImage merge_frames(std::span<const ExposedFloatFrame> frames, const Radiometry& radiometry,
                      const std::string& name, const MergeOptions& options = {});

/// What does not fit in one stack of a session (capture/radiance/steadiness.h), without merging it.
std::vector<Fault> find_stack_faults(const Session& session, const Stack& stack,
                                     const Radiometry& radiometry);

/// Loads and merges the frames of one stack; holds one stack at a time. `label` names it in
/// errors ("pattern fit_03"). Frames that do not fit the rest are refused (InputError naming the
/// file) or corrected as the options say; a sentence for each correction is added to `notes`.
HdrImage merge_stack(const Session& session, const Stack& stack, const std::string& label,
                     const Radiometry& radiometry, const MergeOptions& options = {},
                     std::vector<std::string>* notes = nullptr);

}  // namespace kappamu::capture
