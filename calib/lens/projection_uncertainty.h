// How well a calibrated camera knows where it sees a point, as a standard deviation in pixels
// across the frame (after mrcal, doc/uncertainty.org).
//
// A point fixed in the camera's own frame says little: a shifted principal point is mostly a turned
// camera. So the point p at `distance` before the camera is fixed to the boards. Each view v tells
// where it is, p_v = board_v_from_camera p; when lens and poses change, the camera sees the mean of
// camera_from_board_v p_v. Its derivatives by lens and poses and their joint covariance give that
// of the pixel.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/lens/camera.h"

namespace kappamu::calib {

/// Covariance [px²] of the place of the point seen at `pixel` from `distance_mm` along the axis.
/// `camera` must be fresh from calibrate_camera (its joint covariance is not stored).
Eigen::Matrix2d projection_covariance(const CameraCalibration& camera, const Eigen::Vector2d& pixel,
                                      double distance_mm);

/// Where `camera` sees a point of the true camera's frame that is fixed to the boards, when the
/// boards truly stand at `true_poses` (camera_from_board): the quantity whose covariance is
/// predicted above, for simulations.
Eigen::Vector2d projected_through_boards(const CameraCalibration& camera,
                                         const std::vector<Rigid>& true_poses,
                                         const Eigen::Vector3d& point_in_camera);

/// The standard deviation in its worst direction over the frame, from edge to edge.
struct ProjectionUncertainty {
  double distance_mm = 0.0;
  int columns = 0;
  int rows = 0;
  std::vector<double> deviation_px;  ///< [row][column]
};

ProjectionUncertainty projection_uncertainty(const CameraCalibration& camera, double distance_mm,
                                             int columns = 25);

}  // namespace kappamu::calib
