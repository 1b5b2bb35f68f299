// Poses of a rectangle of known size that explain its corners or its edges in a photograph.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <vector>

#include "calib/lens/lens.h"
#include "calib/sample/pose.h"

namespace kappamu::calib {

/// Rotation vector and translation of camera_from_sample.
using Six = std::array<double, 6>;
/// Pixels in the order of face_corners.
using Corners = std::array<Eigen::Vector2d, 4>;

using Corners3 = std::array<Eigen::Vector3d, 4>;

struct Refined {
  Six pose{};
  double cost = std::numeric_limits<double>::infinity();
  double rms_px = 0.0;
  PoseCovariance covariance = PoseCovariance::Zero();
};

/// Both solutions of the planar problem, ordered by OpenCV, in normalised coordinates.
std::vector<Six> planar_poses(const Corners& corners_px, const Lens& lens, const Corners3& corners);

Refined refine_on_corners(const Corners& corners_px, const Lens& lens, const Corners3& corners,
                          Six pose);

/// Edge k joins corners k and k + 1 in the order of face_corners.
Refined refine_on_edges(const std::vector<std::vector<Eigen::Vector2d>>& edges, const Lens& lens,
                        const Corners3& corners, Six pose);

/// The rotation vector of half a turn at most, which camera_from_sample has.
Six within_half_turn(const Six& pose);

}  // namespace kappamu::calib
