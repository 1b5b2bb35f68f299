// calibration.json: the part of a calibration that a report shows and nothing computes with.
#pragma once

#include <filesystem>
#include <string>

#include "calib/calibrate.h"

namespace kappamu::calib {

/// One JSON object:
///   format "kappamu-calibration", version 1
///   camera, projector: rms_px, model, views: [{name, rms_px, pixels: [[x, y]], residuals: [[x,
///     y]], left_out: [corner], board_pose: [[r00 r01 r02 tx], ...]}]
///   camera: models_tried: [{model, bent, held_out_rms_px, chosen}], uncertainty: {distance_mm,
///     columns, rows, deviation_px} (projection_uncertainty.h)
///   projector: printed_rms_px, face_deviation_px (CalibrationResult::projector_deviation_px)
///   gray_code: {planes: [{name, legible_share, points, width, height, quality [hundredths]}],
///     check_px: of the projected chessboards, null without Gray codes}
///   poses: {calibration, pattern}: {station, face, rms_px, corners_px, edge_px}
///   light: scale, residual_rms of the white target, projector_black
///   chart (or null): residual_rms, found, scale, centres, neutrals: [{patch, published, measured}]
///   warnings: [text], seconds: {stage: s}
/// projector, poses and light are null where they were not calibrated.
std::string residuals_to_json(const CalibrationResult& calibration);

/// Fills what residuals_to_json wrote into a calibration read from the YAML files. Throws
/// InputError naming the file.
void residuals_from_json(const std::filesystem::path& file, CalibrationResult& calibration);

}  // namespace kappamu::calib
