// Whether the frames of a stack show one unchanging scene under one steady light: flicker, drift, a
// mislabelled exposure, a moved sample.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/response/exposed_frame.h"
#include "capture/response/radiometry.h"

namespace kappamu::capture {

/// One frame against the rest of its stack, the exposure times as stated.
struct FrameState {
  double log_gain = 0.0;             ///< ln of its light relative to the stack's middle
  double log_gain_sigma = 0.0;       ///< standard deviation
  std::array<double, 2> shift_px{};  ///< of the picture relative to the stack's middle [px]
  double shift_sigma_px = 0.0;       ///< standard deviation along the worse axis
  double changed_share = 0.0;        ///< of the compared blocks that fit no gain and shift
  bool blank = false;  ///< black where its neighbour promises light; nothing else is known of it
};

/// [frame], in the stack's order. Nothing where a frame shares no light with its neighbours in
/// exposure time and none is to be expected: all dark, all saturated, or a lone frame.
using Steadiness = std::vector<std::optional<FrameState>>;

/// Compares neighbours in exposure time over blocks of 4 x 4 pixels of the middle channel:
/// radiance of the one = (1 + gain) * radiance of the other, shifted; weighted least squares with
/// the noise model's variances, outlying blocks weighted down (Tukey). Of 160,000 blocks or more
/// those on a lattice are compared. Frames are then placed relative to the stack's median.
Steadiness compare_frames(std::span<const ExposedFrame> stack, const Radiometry& radiometry);
Steadiness compare_frames(std::span<const ExposedFloatFrame> stack, const Radiometry& radiometry);

/// What is reported of a frame, beyond both its tolerance and five standard deviations.
struct Fault {
  enum class Kind {
    flicker,  ///< brighter or darker than the rest
    drift,    ///< the whole stack grows brighter or darker in its order; reported of the last frame
    mislabelled,  ///< so much brighter or darker that its exposure time must be wrong
    blank,        ///< black: lens covered, projector off, shutter closed
    moved,        ///< picture shifted
    changed       ///< parts of the picture differ: something passed
  };
  Kind kind = Kind::flicker;
  std::size_t frame = 0;  ///< in the stack
  std::string sentence;   ///< what is wrong, with the numbers; begins with a small letter
};

/// Tolerances of find_faults().
struct SteadyTolerance {
  double gain = 0.005;          ///< relative; 1.5 % or 3 residuals where the response was recovered
  double shift_px = 0.1;        ///< [px]
  double changed_share = 0.03;  ///< of the blocks
};

/// Tolerances that the response's own error allows.
SteadyTolerance tolerance_for(const Radiometry& radiometry);

/// At most one fault of light and one of motion per frame. `files` name the frames.
std::vector<Fault> find_faults(const Steadiness& steadiness, std::span<const double> exposures_s,
                               std::span<const std::string> files,
                               const SteadyTolerance& tolerance);

/// Exposure times that the frames themselves show: stated times gain, with the geometric mean of
/// the unremarkable frames (within 5 % of the median) kept. Frames of unknown state keep theirs.
std::vector<double> steady_exposures(const Steadiness& steadiness,
                                     std::span<const double> exposures_s);

}  // namespace kappamu::capture
