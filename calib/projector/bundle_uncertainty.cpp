#include <cmath>

#include "calib/lens/pose_numbers.h"
#include "calib/projector/bundle_adjustment.h"
#include "calib/projector/bundle_numbers.h"
#include "core/numbers/linear_algebra.h"

namespace kappamu::calib {

Eigen::Vector2d lit_through_boards(const JointCalibration& joint,
                                   const std::vector<Rigid>& true_poses,
                                   const Eigen::Vector3d& point_in_camera) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t v = 0; v < true_poses.size(); ++v) {
    sum += joint.camera.camera_from_board[v] * (true_poses[v].inverse() * point_in_camera);
  }
  return joint.projector.lens.project(joint.projector.projector_from_station *
                                      (sum / static_cast<double>(true_poses.size())));
}

Eigen::Matrix2d projector_covariance(const JointCalibration& joint,
                                     const Eigen::Vector3d& point_in_camera) {
  // Differences: the joint covariance has as many rows as a rig has numbers, once per point.
  const std::vector<Rigid> poses = joint.camera.camera_from_board;
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(2, joint.covariance.rows());
  JointCalibration shifted = joint;
  const auto pixel = [&] { return lit_through_boards(shifted, poses, point_in_camera); };
  const auto differentiate = [&](Eigen::Index at, const auto& set) {
    const double step = 0.01 * std::sqrt(joint.covariance(at, at));
    if (!(step > 0.0)) return;
    set(step);
    const Eigen::Vector2d high = pixel();
    set(-step);
    jacobian.col(at) = (high - pixel()) / (2.0 * step);
    set(0.0);
  };
  for (int k = 0; k < lens_numbers; ++k) {
    differentiate(JointNumbers::projector_at + k, [&](double step) {
      LensNumbers numbers = numbers_of(joint.projector.lens);
      numbers[static_cast<std::size_t>(k)] += step;
      shifted.projector.lens = lens_of(numbers, pixel_shape(joint.projector.model), 0, 0);
    });
  }
  for (int k = 0; k < 6; ++k) {
    differentiate(JointNumbers::pose_at + k, [&](double step) {
      std::array<double, 6> six = six_of(joint.projector.projector_from_station);
      six[static_cast<std::size_t>(k)] += step;
      shifted.projector.projector_from_station = rigid_of(six);
    });
    for (std::size_t v = 0; v < poses.size(); ++v) {
      differentiate(JointNumbers::views_at + 6 * static_cast<Eigen::Index>(v) + k,
                    [&](double step) {
                      std::array<double, 6> six = six_of(poses[v]);
                      six[static_cast<std::size_t>(k)] += step;
                      shifted.camera.camera_from_board[v] = rigid_of(six);
                    });
    }
  }
  return propagated(jacobian, joint.covariance);
}

}  // namespace kappamu::calib
