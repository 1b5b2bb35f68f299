// Frames of a session as luminance, for what is found in them by its shape.
#pragma once

#include "capture/response/radiometry.h"
#include "capture/session/session.h"
#include "core/image.h"

namespace kappamu::calib {

/// A frame as luminance in codes, for bits that are light or dark.
Image<float> load_codes(const capture::Session& session, const capture::Frame& frame);

/// A frame as luminance, linear in light, where an edge is symmetric.
Image<float> load_linear(const capture::Session& session, const capture::Frame& frame,
                         const capture::Radiometry& radiometry);

}  // namespace kappamu::calib
