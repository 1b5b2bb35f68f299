// How far a run's calibration is from the true rig.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/calibrate.h"
#include "data_synthetic/score.h"

namespace kappamu::synthetic {

namespace {

/// Largest distance in pixels between where two optics put the same points of a z face.
double largest_distance_on_face(const calib::Lens& found, const Rigid& found_from_sample,
                                const calib::Lens& truth, const Rigid& truth_from_sample,
                                const GridShape& grid, Face face) {
  constexpr int points = 9;  // per side, corners included
  const double z = is_plus(face) ? grid.nz * grid.voxel_mm : 0.0;
  double largest = 0.0;
  for (int j = 0; j < points; ++j) {
    for (int i = 0; i < points; ++i) {
      const Eigen::Vector3d point(i * grid.nx * grid.voxel_mm / (points - 1),
                                  j * grid.ny * grid.voxel_mm / (points - 1), z);
      largest = std::max(largest, (found.project(found_from_sample * point) -
                                   truth.project(truth_from_sample * point))
                                      .norm());
    }
  }
  return largest;
}

double angle_degrees(const Rigid& a, const Rigid& b) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(a.rotation * b.rotation.transpose()));
  return std::abs(turn.angle()) * 180.0 / std::numbers::pi;
}

/// Distance of the two optical centres in the sample frame.
double centre_distance(const Rigid& a_from_sample, const Rigid& b_from_sample) {
  return (a_from_sample.inverse().translation - b_from_sample.inverse().translation).norm();
}

}  // namespace

CalibrationErrors calibration_errors(const calib::CalibrationResult& found, const Truth& truth) {
  const Rigid camera = truth.camera_from_sample(truth.pattern_station);
  const Rigid projector = truth.projector_from_sample();
  CalibrationErrors errors;
  errors.camera_focal_relative = std::abs(found.camera.lens.fx / truth.camera_lens.fx - 1.0);
  errors.projector_focal_relative =
      std::abs(found.projector.lens.fx / truth.projector.lens.fx - 1.0);
  errors.camera_face_px =
      largest_distance_on_face(found.camera.lens, found.pattern_pose.camera_from_sample,
                               truth.camera_lens, camera, truth.grid, truth.seen_face);
  errors.projector_face_px =
      largest_distance_on_face(found.projector.lens, found.projector_from_sample,
                               truth.projector.lens, projector, truth.grid, truth.lit_face);
  errors.camera_angle_degrees = angle_degrees(found.pattern_pose.camera_from_sample, camera);
  errors.camera_position_mm = centre_distance(found.pattern_pose.camera_from_sample, camera);
  errors.projector_angle_degrees = angle_degrees(found.projector_from_sample, projector);
  errors.projector_position_mm = centre_distance(found.projector_from_sample, projector);
  for (std::size_t c = 0; c < found.scale.size() && c < truth.responsivity.size(); ++c) {
    errors.scale_relative =
        std::max(errors.scale_relative, std::abs(found.scale[c] / truth.responsivity[c] - 1.0));
  }
  errors.projector_black_relative =
      std::abs(found.white.projector_black / truth.projector.black_level - 1.0);
  return errors;
}

}  // namespace kappamu::synthetic
