// What a camera calibration is worth against the number of board views it is made from.
//
// The simulated rig's own board poses (data_synthetic/rig/rig.h), drawn at random from sixty;
// corners by geometry with noise, lens model chosen as in a real calibration. The error is where
// the calibrated camera sees points at the sample's distance, over the whole frame, against where
// the true one does (calib/lens/projection_uncertainty.h).
#pragma once

#include <cstdint>
#include <vector>

#include "studies/subject.h"

namespace kappamu::studies {

struct ViewsOptions {
  std::vector<int> views{3, 4, 5, 6, 8, 10, 13, 16, 20, 25, 30, 40};
  int runs = 60;  ///< calibrations per count, each with other poses and noise
  /// Per coordinate: between rendered corners' scatter of 0.0013 px and the 0.10 px that real
  /// boards leave (docs/calibration.md).
  double corner_noise_px = 0.03;
  std::uint64_t seed = 1;
};

/// Root mean squares over the runs.
struct ViewsCase {
  int views = 0;
  int refused = 0;               ///< runs in which the views did not determine the lens
  double error_px = 0.0;         ///< over the frame
  double predicted_px = 0.0;     ///< what the calibrations themselves state
  double focal_relative = 0.0;   ///< error of fx
  double focal_predicted = 0.0;  ///< stated
};

std::vector<ViewsCase> measure_views(const ViewsOptions& options, Progress& progress);

}  // namespace kappamu::studies
