// The order of all numbers of a joint calibration (joint.h), in its covariance. Included by .cpp
// files only.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "calib/lens/lens_model.h"

namespace kappamu::calib {

struct JointNumbers {
  LensNumbers camera{};
  std::array<double, 2> bend{};
  LensNumbers projector{};
  std::array<double, 6> projector_pose{};
  std::vector<std::array<double, 6>> poses;

  static constexpr Eigen::Index camera_at = 0;
  static constexpr Eigen::Index bend_at = lens_numbers;
  static constexpr Eigen::Index projector_at = lens_numbers + 2;
  static constexpr Eigen::Index pose_at = 2 * lens_numbers + 2;
  static constexpr Eigen::Index views_at = 2 * lens_numbers + 8;
  Eigen::Index size() const { return views_at + 6 * static_cast<Eigen::Index>(poses.size()); }
};

}  // namespace kappamu::calib
