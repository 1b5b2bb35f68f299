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

}  // namespace kappamu::calib
