// One simulated rig with all it photographed, and what its measurements become when it is
// calibrated otherwise: with lenses that fewer or noisier corners give, with those drawn from a
// calibration's own covariance, with the true ones.
#pragma once

#include <filesystem>
#include <map>
#include <random>
#include <string>

#include "calib/calibrate.h"
#include "calib/measure.h"
#include "calib/projector/bundle_adjustment.h"
#include "capture/session/session.h"
#include "core/progress.h"
#include "core/surface_measurements.h"
#include "data_synthetic/simulation_options.h"
#include "data_synthetic/truth.h"

namespace kappamu::studies {

/// What boards and planes tell: the part of a calibration whose uncertainty is joint (joint.h).
struct Lenses {
  calib::Lens camera;
  calib::Lens projector;
  Rigid projector_from_station;
};
Lenses true_lenses(const synthetic::Truth& truth);
/// A rig as likely as the calibrated one, by the joint covariance.
Lenses drawn(const calib::JointCalibration& joint, std::mt19937_64& random);

/// What a calibration makes of the rig's boards and planes, corners by geometry with noise.
calib::JointCalibration calibrate_corners(const synthetic::Rig& rig, double noise_px,
                                          std::mt19937_64& random);

class RigTrial {
 public:
  /// Simulates into `folder` unless it was, calibrates the session and merges its fit patterns.
  RigTrial(const synthetic::SimulationOptions& options, const std::filesystem::path& folder,
           const std::string& device, Progress& progress);
  /// The same with `count` of the patterns' exposures, the first, the last and those evenly
  /// between: camera response, light and pictures are found anew, lenses stay. `count` − 1 divides
  /// the session's number less one.
  RigTrial with_exposures(int count) const;

  const synthetic::Truth& truth() const { return truth_; }
  const std::filesystem::path& truth_folder() const { return truth_folder_; }
  /// As found in the session's own pictures.
  const calib::CalibrationResult& calibration() const { return calibration_; }
  /// With other lenses: sample and light are found again in the session's pictures.
  calib::CalibrationResult calibrated(const Lenses& lenses) const;

  /// The fit patterns by the session's merged pictures.
  SurfaceMeasurements measured(const calib::CalibrationResult& calibration,
                               const calib::MeasureOptions& options = {}) const;
  /// By pictures without noise under the true scale; variances are those of measured().
  SurfaceMeasurements exact(calib::CalibrationResult calibration) const;

 private:
  void merge();

  std::filesystem::path truth_folder_;
  capture::Session session_;
  synthetic::Truth truth_;
  calib::CalibrationResult calibration_;
  std::map<std::string, capture::HdrImage> pictures_;  ///< merged, by pattern
};

}  // namespace kappamu::studies
