// Where the sample stands: the pose of a face of known size from its outline in one photograph.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "calib/lens.h"
#include "core/grid.h"
#include "core/image.h"
#include "core/rigid.h"

namespace kappamu::calib {

struct SamplePose {
  std::string station;
  Face face = Face::z_minus;
  Rigid camera_from_sample;  ///< camera frame of that station
  /// Covariance of its rotation vector [rad] and translation [mm], edge points taken as
  /// independent.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double rms_px = 0.0;  ///< distance of edge points (or given corners) from the projected outline
  std::array<Eigen::Vector2d, 4> corners_px;  ///< projected corners, order of docs/conventions.md
  std::vector<Eigen::Vector2d> edge_px;       ///< edge points found; empty when corners were given
};

/// Finds the outline of `face` in a grey picture (linear in light, so that an edge lies at the
/// steepest drop), and the pose that fits all its edge points best: distances of points to
/// projected edges, Cauchy loss, both solutions of the planar pose problem tried (Collins & Bartoli
/// 2014). Throws InputError naming `name` if no outline is found or it does not fit the face's
/// size.
SamplePose find_sample_pose(const Image<float>& grey, const Lens& lens, const GridShape& grid,
                            Face face, const std::string& name);

/// The same from corners given by hand, in the order of docs/conventions.md.
SamplePose pose_from_corners(const std::array<Eigen::Vector2d, 4>& corners_px, const Lens& lens,
                             const GridShape& grid, Face face, const std::string& name);

}  // namespace kappamu::calib
