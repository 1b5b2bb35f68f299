// Which exposures and calibration views a rig needs for a given error of κ and μ: found, by fits to
// measurements of simulated rigs whose one part is as good as so many photographs make it, and
// predicted, by carrying that part's stated uncertainty through the same chain.
//
//   views      camera, projector and their places by so many boards and planes, corners found
//              within `corner_noise_px`; predicted: lenses drawn from the joint covariance
//              (calib/projector/bundle_adjustment.h). Each time sample and light are found again in
//              the same pictures.
//   exposures  the patterns' stacks, response and radiance scale with them; predicted: the merge's
//              variance alone.
//
// Found and predicted are what moves between fits of equal weight (dense_fit.h) to measurements
// with that part's error and without it: what the rig adds to the fit's own error. Rendered corners
// are found within 0.002 px, so that views would not tell; theirs are drawn.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "studies/subject.h"

namespace kappamu::studies {

struct RigViews {
  int boards = 0;  ///< views of the printed board
  int planes = 0;  ///< poses of the projector plane
};

struct RigNeedsOptions {
  std::vector<RigViews> views{{3, 3}, {6, 3}, {10, 4}, {15, 6}, {25, 10}};
  std::vector<int> exposures{2, 3, 5, 9};  ///< of nine from 1/30 to 8 s, even in ln t
  int rigs = 4;                            ///< seeds: samples, mounts, stations, noise
  int draws = 2;                           ///< rigs drawn from each calibration's covariance
  double corner_noise_px = 0.1;            ///< per coordinate, of the camera's pixels
  std::uint64_t seed = 1;                  ///< of the first rig
  std::string device = "reference";
  std::filesystem::path folder;  ///< of the sessions; what is there already is not made again
};
RigNeedsOptions quick_rig_needs();

/// A row per case, medians over rigs, of the channel G. part: "views" (five exposures), "exposures"
/// (under the lenses of rendered corners), "true lenses" (five exposures; κ and μ are the errors of
/// the fit against the truth); boards, planes, exposures; refused: calibrations that ended with an
/// error; camera_px, projector_px: largest error over the seen face [camera px] and the lit face
/// [projector px]; turn_degrees of the sample before the camera; scale_relative: error of the
/// radiance scale, worst channel; value_relative: change of a measurement; log_kappa, log_mu and as
/// predicted: |δ log| of the median voxel; validation_E of this volume (synthetic::truth_error).
Json measure_rig_needs(const RigNeedsOptions& options, Progress& progress);

}  // namespace kappamu::studies
