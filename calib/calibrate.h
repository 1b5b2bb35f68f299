// Everything a session's calibration shots tell, found in one go.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calib/camera.h"
#include "calib/pose.h"
#include "calib/projection_uncertainty.h"
#include "calib/projector.h"
#include "calib/radiometry.h"
#include "capture/merge.h"
#include "capture/radiometry.h"
#include "capture/session.h"
#include "core/progress.h"
#include "core/rigid.h"

namespace kappamu::calib {

struct CalibrationResult {
  capture::Radiometry radiometry;  ///< of the camera, for merging stacks
  CameraCalibration camera;
  /// Across the camera's frame, at the sample's distance from the pattern station.
  ProjectionUncertainty camera_uncertainty;
  ProjectorCalibration projector;
  SamplePose calibration_pose;  ///< seen from the calibration station
  SamplePose pattern_pose;      ///< seen from the pattern station; the same where they agree
  Rigid projector_from_sample;
  WhiteReference white;  ///< flat 1 and black 0 where the session has no white target
  std::optional<ChartReference> chart;
  /// [channel] full scales per second for unit radiance, in use: the white target's or, without
  /// one, the chart's.
  std::vector<double> scale;
  std::vector<std::string> warnings;      ///< sentences for the user; also sent to Progress::warn
  std::map<std::string, double> seconds;  ///< wall time by stage
};

/// Calibrates camera response, camera, projector, sample pose and light scale from
/// session.calibration. Throws InputError, one sentence naming file and fix, for boards or outlines
/// not found, too few views, views that do not determine what is asked, and a session with neither
/// white target nor colour chart. `hdr` says how stacks are merged.
CalibrationResult calibrate(const capture::Session& session, Progress& progress,
                            const capture::HdrOptions& hdr = {});

}  // namespace kappamu::calib
