// The camera's radiometry: black level, inverse response and noise, found from a session's own
// frames. The one door for everything that merges stacks.
#pragma once

#include <optional>
#include <vector>

#include "capture/response/response.h"
#include "capture/session/session.h"
#include "core/progress.h"

namespace kappamu::capture {

/// Inverse response of the camera per channel: linear signal as a fraction of full scale for each
/// code value.
struct Response {
  /// [channel][code], codes 0 ... 2^bits - 1; rising, 0 at the black level, 1 at the largest code.
  std::vector<std::vector<double>> linear;
};

/// Noise of one channel.
struct Noise {
  double electrons_full_scale = 0.0;  ///< photo-electrons at full scale: shot noise is their root
  double read_noise_electrons = 0.0;  ///< standard deviation [electrons], quantisation apart
  bool estimated = false;             ///< found from frames, not stated by the session
};

struct Radiometry {
  int bit_depth = 8;
  Response response;
  std::vector<double> black_level;      ///< [channel], code value (not whole) that means no light
  std::vector<Noise> noise;             ///< [channel]
  std::vector<ResponseReport> reports;  ///< [channel] of the recovery; empty if encoding is linear
};

/// Black level from the dark frames or, without any, from the first stack (dark_frames.h); the
/// response by encoding (identity, or recovered from white
/// target, chart and a few pattern stacks); noise from the session or, where it is silent,
/// from dark frames and stack residuals (docs/hdr.md). Throws InputError if a frame is bad or
/// there are too few exposures to recover a response.
Radiometry find_radiometry(const Session& session, Progress& progress);

/// A linear response: 0 at black_level, 1 at white_level (absent: the largest code) and above, a
/// straight line below, also below black.
std::vector<double> linear_response(int bit_depth, double black_level,
                                    std::optional<int> white_level = std::nullopt);

}  // namespace kappamu::capture
