// A calibration as a folder: OpenCV-style YAML for people and other programs, JSON for the report.
#pragma once

#include <filesystem>

#include "calib/calibrate.h"

namespace kappamu::calib {

/// Writes into `folder` (made if missing), matrices as OpenCV's FileStorage reads them:
///   camera.yml      camera_matrix, distortion_coefficients, image size, model, covariance (12 x
///                   12 of fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6), board_bend_mm,
///                   rms_px
///   projector.yml   the same for the projector, and projector_from_station [mm]
///   pose.yml        camera_from_sample for both stations with covariance from the outline and
///                   lens_covariance from the lens (6 x 6, rotation vector [rad] and translation
///                   [mm]), projector_from_sample
///   response.yml    inverse response, black level and noise per channel
///   radiometry.yml  scale, flat field, projector black level, room light, projector_values and
///                   projector_light (projector_curve.h)
///   calibration.json  residuals: per view RMS, corners and residual vectors, neutral patches,
///                   warnings, seconds; written last, so a folder that has one is complete
/// Numbers are written so that reading gives the same bits.
void save_calibration(const std::filesystem::path& folder, const CalibrationResult& calibration);

/// camera.yml and calibration.json alone, and projector.yml where it was calibrated
/// (calibrate_lenses_alone).
void save_lenses(const std::filesystem::path& folder, const CalibrationResult& calibration);

/// response.yml alone.
void save_response(const std::filesystem::path& folder, const capture::Radiometry& radiometry);

/// Throws InputError naming the file if one is missing, damaged or lacks a field.
CalibrationResult load_calibration(const std::filesystem::path& folder);

}  // namespace kappamu::calib
