// Everything a session's calibration shots tell, found in one go.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calib/lens/camera.h"
#include "calib/lens/projection_uncertainty.h"
#include "calib/light/radiometry.h"
#include "calib/projector/projector.h"
#include "calib/projector/projector_curve.h"
#include "calib/sample/pose.h"
#include "capture/radiance/merge.h"
#include "capture/response/radiometry.h"
#include "capture/session/session.h"
#include "core/image.h"
#include "core/progress.h"
#include "core/rigid.h"

namespace kappamu::calib {

/// What a plane's Gray code tells.
struct GrayCodeView {
  std::string name;            ///< first file of the code
  double legible_share = 0.0;  ///< of the camera's pixels
  int points = 0;              ///< of the projector's frame located in the picture
  /// [y][x] contrast of the weakest bit (gray_code.h), mean over blocks; 0 where not legible.
  Image<float> quality;
};

struct CalibrationResult {
  capture::Radiometry radiometry;  ///< of the camera, for merging stacks
  /// Adjusted together with the projector (joint.h) where the projected corners agree with it.
  CameraCalibration camera;
  /// Across the camera's frame, at the sample's distance from the pattern station.
  ProjectionUncertainty camera_uncertainty;
  /// From the Gray codes where every plane has one, else from the projected chessboards.
  ProjectorCalibration projector;
  /// Of the projector pixel that lights a corner of the lit face, per coordinate, the worst
  /// corner's: what camera, projector and planes leave uncertain together (joint.h), without the
  /// sample's pose.
  double projector_deviation_px = 0.0;
  std::vector<GrayCodeView> gray_code;
  /// Of the projected chessboards' corners under a projector calibrated from Gray codes, distance
  /// in projector pixels, root mean square: corners that took no part in it.
  std::optional<double> gray_code_check_px;
  SamplePose calibration_pose;  ///< seen from the calibration station
  SamplePose pattern_pose;      ///< seen from the pattern station; the same where they agree
  Rigid projector_from_sample;
  WhiteReference white;  ///< flat 1 and black 0 where the session has no white target
  /// Absent where white_target has no levels: light then is taken as proportional to the value.
  std::optional<ProjectorCurve> projector_curve;
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
                            const capture::MergeOptions& hdr = {});

/// What calibrate() does once camera response, camera and projector are known, which `result` has:
/// finds the sample in its views and the scale of light. Throws as calibrate() does.
void calibrate_sample(const capture::Session& session, CalibrationResult& result,
                      Progress& progress, const capture::MergeOptions& hdr = {});

/// Camera and, where the session has projector planes, projector, of a session that needs nothing
/// else (capture::board_session). Codes of an unknown response are read as sRGB's, which boards
/// need no better. Throws as calibrate() does.
CalibrationResult calibrate_lenses_alone(const capture::Session& session, Progress& progress,
                                         const std::optional<KnownLens>& known = std::nullopt);

}  // namespace kappamu::calib
