// The projector as a camera run backwards: chessboards it projects on planes whose pose a printed
// board tells (Zhang & Huang 2006; Kimura, Mochimaru & Kanade 2007), refined jointly with those
// poses.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calib/lens/camera.h"
#include "calib/lens/lens.h"
#include "calib/targets/board_corners.h"
#include "capture/session/session.h"
#include "core/rigid.h"

namespace kappamu::calib {

/// One plane: printed and projected corners, both in camera pixels.
struct PlaneView {
  std::string name;  ///< file of the projected board, for messages and the report
  BoardCorners printed;
  BoardCorners projected;
};

struct ProjectorCalibration {
  Lens lens;  ///< projector pixels; `width`, `height` of the projector
  LensModel model = LensModel::radial2_tangential;
  /// As CameraCalibration's; the camera's own uncertainty is not in it.
  LensCovariance covariance = LensCovariance::Zero();
  Rigid projector_from_station;  ///< from the camera frame at the calibration station
  /// Covariance of its rotation vector [rad] and translation [mm].
  Eigen::Matrix<double, 6, 6> pose_covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double rms_px = 0.0;                    ///< projected corners, distance in projector pixels
  double printed_rms_px = 0.0;            ///< printed corners of the same planes, in camera pixels
  std::vector<Rigid> station_from_plane;  ///< printed board's corner (i, j) at square * (i, j, 0)
  std::vector<ViewResidual> views;        ///< pixels and residuals in projector pixels
  bool converged = false;
};

/// Calibrates from at least three planes. Distortion is never left out, which would move the
/// principal point and, through adjust_jointly, the camera; k1, k2, p1 and p2 have Gaussian priors
/// (lens_model.h) in place of a choice, so that what the planes do not tell stays in the
/// covariance. Throws InputError for fewer than three planes, planes that do not determine the
/// projector, and one plane that contradicts all others.
ProjectorCalibration calibrate_projector(const Lens& camera, const capture::Board& printed,
                                         const capture::ProjectedBoard& projected,
                                         const std::vector<PlaneView>& planes, int width,
                                         int height);

/// Which projector pixel corner k of a projected board is.
Eigen::Vector2d projector_pixel(const capture::ProjectedBoard& projected,
                                const BoardCorners& corners, std::size_t k);

/// Camera pixels per projector pixel on a plane, from the spread of its projected corners.
double camera_px_per_projector_px(const PlaneView& plane, const capture::ProjectedBoard& projected);

/// Sets views, rms_px and printed_rms_px from lens and poses.
void measure_residuals(const Lens& camera, const capture::Board& printed,
                       const capture::ProjectedBoard& projected,
                       const std::vector<PlaneView>& planes, ProjectorCalibration& projector);

/// Distance in projector pixels, root mean square, of projected corners from where `projector` has
/// them: a check by corners that took no part in its calibration, on the planes that did.
double projected_board_rms(const Lens& camera, const ProjectorCalibration& projector,
                           const capture::ProjectedBoard& projected,
                           const std::vector<PlaneView>& planes);

/// Where the ray through a pixel meets the plane z = 0 of `camera_from_plane`, in plane
/// coordinates.
Eigen::Vector3d meet_plane(const Lens& lens, const Rigid& camera_from_plane,
                           const Eigen::Vector2d& pixel);

}  // namespace kappamu::calib
