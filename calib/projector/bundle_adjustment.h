// Bundle adjustment of camera, projector, printed board and planes together.
//
// The camera calibrated alone knows nothing of the projected corners, and the projector calibrated
// with that camera held says nothing of the camera's share in its uncertainty. Here both lenses,
// the projector's pose, the board's bend and every board's pose are one least-squares problem:
// printed corners in camera pixels, and for each projected corner the camera's ray through it, met
// with its plane and seen by the projector, in camera pixels. Both kinds are weighed by their own
// scatter, under Huber's loss at three standard deviations.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/lens/camera.h"
#include "calib/projector/projector.h"

namespace kappamu::calib {

/// What the adjustment starts from and what it sees. The last of `views` are the printed boards of
/// `planes`, in their order.
struct JointSetting {
  const std::vector<BoardView>& views;
  const capture::Board& printed;
  const capture::ProjectedBoard& projected;
  const std::vector<PlaneView>& planes;
};

struct JointCalibration {
  CameraCalibration camera;
  ProjectorCalibration projector;
  /// Of camera lens (12), bend (2), projector lens (12), projector pose (6), then six per view
  /// (rotation vector [rad], translation [mm]); camera.joint_covariance is the part without the
  /// projector.
  Eigen::MatrixXd covariance;
  bool converged = false;
};

/// Refines `camera` and `projector` with the lens models they have; corners that the camera's
/// calibration left out stay out. Throws InputError if the views do not determine both.
JointCalibration adjust_jointly(const JointSetting& setting, const CameraCalibration& camera,
                                const ProjectorCalibration& projector);

/// Whether the printed corners are explained as well as by `camera` alone, within a tenth of the
/// RMS (where models hold, projected corners add a hundredth). Planes that are not flat beyond the
/// printed board, or moved between their pictures, would reach the camera's lens otherwise.
bool agrees(const JointCalibration& joint, const CameraCalibration& camera);

/// Covariance [px²] of the projector pixel that lights a point of the camera's frame at the
/// calibration station, the point being fixed to the boards (projection_uncertainty.h).
Eigen::Matrix2d projector_covariance(const JointCalibration& joint,
                                     const Eigen::Vector3d& point_in_camera);

/// Which projector pixel `joint` says lights a point of the true camera's frame that is fixed to
/// the boards, which truly stand at `true_poses`: the quantity whose covariance is predicted above.
Eigen::Vector2d lit_through_boards(const JointCalibration& joint,
                                   const std::vector<Rigid>& true_poses,
                                   const Eigen::Vector3d& point_in_camera);

}  // namespace kappamu::calib
