// A rigid motion of six numbers applied to points of any scalar, for Ceres' automatic derivatives.
#pragma once

#include <ceres/rotation.h>

#include <Eigen/Core>

namespace kappamu::calib {

/// `six`: turn (axis times angle), then translation.
template <class T>
Eigen::Matrix<T, 3, 1> moved(const T* six, const Eigen::Matrix<T, 3, 1>& point) {
  Eigen::Matrix<T, 3, 1> result;
  ceres::AngleAxisRotatePoint(six, point.data(), result.data());
  for (int k = 0; k < 3; ++k) result[k] += six[3 + k];
  return result;
}

/// Where a ray from the origin meets the plane z = 0 of a frame that stands at `six`.
template <class T>
Eigen::Matrix<T, 3, 1> met_by(const T* six, const Eigen::Matrix<T, 3, 1>& ray) {
  const Eigen::Matrix<T, 3, 1> axis(T(0.0), T(0.0), T(1.0));
  Eigen::Matrix<T, 3, 1> normal;
  ceres::AngleAxisRotatePoint(six, axis.data(), normal.data());
  const Eigen::Map<const Eigen::Matrix<T, 3, 1>> origin(six + 3);
  return ray * (normal.dot(origin) / normal.dot(ray));
}

}  // namespace kappamu::calib
