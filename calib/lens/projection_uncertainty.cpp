#include "calib/lens/projection_uncertainty.h"

#include <ceres/jet.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <cmath>

#include "calib/lens/lens_model.h"
#include "calib/lens/opencv_convert.h"
#include "core/error.h"
#include "core/numbers/linear_algebra.h"

namespace kappamu::calib {
namespace {

/// d(project(lens, point)) / d(lens numbers).
Eigen::Matrix<double, 2, lens_numbers> by_lens(const CameraCalibration& camera,
                                               const Eigen::Vector3d& point) {
  using Jet = ceres::Jet<double, lens_numbers>;
  const LensNumbers numbers = numbers_of(camera.lens);
  std::array<Jet, lens_numbers> jets;
  for (int k = 0; k < lens_numbers; ++k) jets[k] = Jet(numbers[k], k);
  const auto pixel =
      project_numbers<Jet>(jets.data(), pixel_shape(camera.model), point.cast<Jet>());
  Eigen::Matrix<double, 2, lens_numbers> jacobian;
  jacobian << pixel.x().v.transpose(), pixel.y().v.transpose();
  return jacobian;
}

/// d(project(lens, p + (pose(p_v) - p) / views)) / d(pose).
Eigen::Matrix<double, 2, 6> by_pose(const CameraCalibration& camera, std::size_t view,
                                    const Eigen::Vector3d& point) {
  using Jet = ceres::Jet<double, 6>;
  const Rigid& camera_from_board = camera.camera_from_board[view];
  const Eigen::Vector3d in_board = camera_from_board.inverse() * point;
  const std::array<double, 6> pose = six_of(camera_from_board);
  std::array<Jet, 6> jets;
  for (int k = 0; k < 6; ++k) jets[k] = Jet(pose[k], k);
  const Eigen::Matrix<Jet, 3, 1> fixed = in_board.cast<Jet>();
  Eigen::Matrix<Jet, 3, 1> moved;
  ceres::AngleAxisRotatePoint(jets.data(), fixed.data(), moved.data());
  const double share = 1.0 / static_cast<double>(camera.camera_from_board.size());
  for (int k = 0; k < 3; ++k) moved[k] = point[k] + (moved[k] + jets[3 + k] - point[k]) * share;
  std::array<Jet, lens_numbers> lens;
  const LensNumbers numbers = numbers_of(camera.lens);
  for (int k = 0; k < lens_numbers; ++k) lens[k] = Jet(numbers[k]);
  const auto pixel = project_numbers<Jet>(lens.data(), pixel_shape(camera.model), moved);
  Eigen::Matrix<double, 2, 6> jacobian;
  jacobian << pixel.x().v.transpose(), pixel.y().v.transpose();
  return jacobian;
}

}  // namespace

Eigen::Matrix2d projection_covariance(const CameraCalibration& camera, const Eigen::Vector2d& pixel,
                                      double distance_mm) {
  check(camera.joint_covariance.size() > 0, "projection_covariance wants a fresh calibration");
  const Eigen::Vector3d point = distance_mm * camera.lens.unproject(pixel);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(2, camera.joint_covariance.rows());
  jacobian.leftCols<lens_numbers>() = by_lens(camera, point);
  for (std::size_t v = 0; v < camera.camera_from_board.size(); ++v) {
    jacobian.middleCols<6>(lens_numbers + 2 + 6 * static_cast<Eigen::Index>(v)) =
        by_pose(camera, v, point);
  }
  return propagated(jacobian, camera.joint_covariance);
}

Eigen::Vector2d projected_through_boards(const CameraCalibration& camera,
                                         const std::vector<Rigid>& true_poses,
                                         const Eigen::Vector3d& point_in_camera) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t v = 0; v < true_poses.size(); ++v) {
    sum += camera.camera_from_board[v] * (true_poses[v].inverse() * point_in_camera);
  }
  return camera.lens.project(sum / static_cast<double>(true_poses.size()));
}

ProjectionUncertainty projection_uncertainty(const CameraCalibration& camera, double distance_mm,
                                             int columns) {
  ProjectionUncertainty result;
  result.distance_mm = distance_mm;
  result.columns = columns;
  const double step = static_cast<double>(camera.lens.width) / (columns - 1);
  result.rows = std::max(2, static_cast<int>(std::lround(camera.lens.height / step)) + 1);
  for (int j = 0; j < result.rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Eigen::Vector2d pixel(camera.lens.width * i / (columns - 1.0) - 0.5,
                                  camera.lens.height * j / (result.rows - 1.0) - 0.5);
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
      solver.computeDirect(projection_covariance(camera, pixel, distance_mm),
                           Eigen::EigenvaluesOnly);
      result.deviation_px.push_back(std::sqrt(std::max(0.0, solver.eigenvalues()[1])));
    }
  }
  return result;
}

}  // namespace kappamu::calib
