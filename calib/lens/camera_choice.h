// Which lens model the views need: the one that explains views it was not fitted to best.
#pragma once

#include <vector>

#include "calib/lens/camera_fit.h"

namespace kappamu::calib {

struct CameraChoice {
  CameraFit fit;
  std::vector<ModelScore> scores;
};

/// Fits none, k1, k2, (p1, p2), k3 and (k4, k5, k6) in turn for a flat board, those up to the best
/// for a bent one, and compares their errors of views left out. Up to p1, p2 a simpler model has to
/// win by two standard errors of the difference over the views: a missed p1, p2 moves the principal
/// point by pixels, few views cannot tell, and an idle one costs no more than its stated deviation.
/// k3 and the rational model have to win by two themselves, the bend by one: k3 trades against k2
/// inside the boards' reach and runs wild outside it (docs/calibration.md).
CameraChoice choose_camera(const CameraSetting& setting, const CameraFit& start);

}  // namespace kappamu::calib
