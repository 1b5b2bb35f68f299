// Where the sample stands: the pose of a face of known size from its outline in one photograph.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "calib/lens/camera.h"
#include "calib/lens/lens.h"
#include "core/grid.h"
#include "core/image.h"
#include "core/rigid.h"

namespace kappamu::calib {

using PoseCovariance = Eigen::Matrix<double, 6, 6>;

struct SamplePose {
  std::string station;
  Face face = Face::z_minus;
  Rigid camera_from_sample;  ///< camera frame of that station
  /// Covariance of its rotation vector [rad] and translation [mm] from the scatter of the edge
  /// points, neighbours being correlated as their residuals show; the lens is taken as known.
  PoseCovariance covariance = PoseCovariance::Zero();
  /// What the lens' own uncertainty adds.
  PoseCovariance lens_covariance = PoseCovariance::Zero();
  double rms_px = 0.0;  ///< distance of edge points (or given corners) from the projected outline
  std::array<Eigen::Vector2d, 4> corners_px;  ///< projected corners, order of docs/conventions.md
  std::vector<Eigen::Vector2d> edge_px;       ///< edge points found; empty when corners were given

  PoseCovariance total_covariance() const { return covariance + lens_covariance; }
};

/// One standard deviation of a pose, by total_covariance().
struct PoseUncertainty {
  Eigen::Vector3d place_mm;   ///< of a point of the sample, along the camera's x, y, z
  double turn_degrees = 0.0;  ///< about the worst axis
};
PoseUncertainty pose_uncertainty(const SamplePose& pose, const Eigen::Vector3d& point_in_sample);

/// Finds the outline of `face` in a grey picture (linear in light, so that an edge lies at the
/// steepest drop), and the pose that fits all its edge points best: distances of points to
/// projected edges, Cauchy loss, both solutions of the planar pose problem tried (Collins & Bartoli
/// 2014). `lens_covariance` is the calibration's. Throws InputError naming `name` if no outline is
/// found or it does not fit the face's size.
SamplePose find_sample_pose(const Image<float>& grey, const Lens& lens, const GridShape& grid,
                            Face face, const std::string& name,
                            const LensCovariance& lens_covariance = LensCovariance::Zero());

/// The same from corners given by hand, in the order of docs/conventions.md.
SamplePose pose_from_corners(const std::array<Eigen::Vector2d, 4>& corners_px, const Lens& lens,
                             const GridShape& grid, Face face, const std::string& name,
                             const LensCovariance& lens_covariance = LensCovariance::Zero());

}  // namespace kappamu::calib
