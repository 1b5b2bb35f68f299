// Whether the printed board's squares have the stated size. They set the rig's scale and with it
// the projector's place; the block's own size sets the sample's, and no photograph of either
// compares the two. The patterns do: with squares of another size the light falls elsewhere on the
// lit face than calibration puts it, along the line between camera and projector.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "core/surface_measurements.h"
#include "inverse/data_checks/consistency.h"

namespace kappamu::pipeline {

/// How far [mm, sample frame] the light at the middle of `lit_face` truly lies from where
/// `calibration` puts it, per unit of ln(true square size / stated size).
Eigen::Vector3d light_shift_per_log_square(const calib::CalibrationResult& calibration,
                                           const GridShape& grid, Face lit_face);

struct SquareSize {
  inverse::Estimate
      log_factor;         ///< ln(true size / stated size) that the shift along the line tells
  double limit = 0.0;     ///< of its size, beyond which a shift is reported (consistency.h)
  bool explains = false;  ///< there is a shift, and nothing of it across the line that is reported
};

/// Absent where `consistency` was not checked.
std::optional<SquareSize> check_square_size(const inverse::Consistency& consistency,
                                            const calib::CalibrationResult& calibration,
                                            const SurfaceMeasurements& measurements);

/// What one channel's shift gives the reader.
struct ShiftFindings {
  std::vector<std::string> warnings;
  std::vector<std::string> notes;
};

/// By channel: a warning of a shift that all of them share, in the least shifted one, and another
/// where another size of the squares explains it; otherwise what the shift tells of the size. The
/// squares are left out without a calibration.
std::vector<ShiftFindings> check_shift(std::span<const inverse::Consistency> channels,
                                       const std::optional<calib::CalibrationResult>& calibration,
                                       const SurfaceMeasurements& measurements);

}  // namespace kappamu::pipeline
