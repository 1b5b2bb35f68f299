// Which projector pixel each camera pixel sees, from a projected Gray code, and points of the
// projector's frame located in the camera's picture by it.
#pragma once

#include "calib/projector/projector_map.h"
#include "capture/session/session.h"

namespace kappamu::calib {

/// Reads the frames of ProjectorPlane::gray_code, grey and of equal size, in any linear or monotone
/// scale. White, black and two more frames are held at a time. A pixel is legible where white
/// exceeds black by 4 % of the brightest, every bit differs from its inverse by 2 % of it (OpenCV
/// structured_light's rule with both thresholds at 5 of 255 gives the same codes,
/// tests/calib/projector/gray_code_test.cpp), and the code lies in the projector's frame. The
/// finest bit of columns or rows may be illegible, as where the camera's pixels are as wide as the
/// projector's: its edges run through the middle of the two pixels that it tells apart, and that is
/// what such a pixel sees.
ProjectorMap decode_gray_code(const FrameSource& frames, const capture::Projector& projector);

}  // namespace kappamu::calib
