// Camera and projector from printed boards, projected boards and Gray codes.
#pragma once

#include "calib/calibrate.h"
#include "calib/calibration_stages.h"
#include "calib/projector/bundle_adjustment.h"

namespace kappamu::calib {

/// Fills result.camera and, where the session has projector planes, result.projector and
/// gray_code; result.radiometry makes the frames linear. The joint adjustment is empty without
/// planes. The camera's lens may be known (camera.h). Throws as calibrate() does.
JointCalibration calibrate_lenses(const capture::Session& session, Stages& stages,
                                  CalibrationResult& result,
                                  const std::optional<KnownLens>& known = std::nullopt);

}  // namespace kappamu::calib
