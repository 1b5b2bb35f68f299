// Rigid motions between named frames: `camera_from_sample` maps sample coordinates to camera
// coordinates, and reads right by adjacency: camera_from_board = camera_from_sample *
// sample_from_board.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace kappamu {

/// x_to = rotation * x_from + translation, lengths in mm.
struct Rigid {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return rotation * point + translation;
  }
  Rigid operator*(const Rigid& other) const {
    return {rotation * other.rotation, rotation * other.translation + translation};
  }
  Rigid inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
};

}  // namespace kappamu
