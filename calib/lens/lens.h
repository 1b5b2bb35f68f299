// The pinhole lens with OpenCV's distortion, for cameras and, run backwards, projectors
// (Brown 1971; Zhang 2000). Frame and pixels: docs/conventions.md.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "core/numbers/region.h"

namespace kappamu::calib {

/// Pixel of a direction: x' = X/Z, y' = Y/Z, r² = x'² + y'²,
///   ρ = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶)
///   x'' = x' ρ + 2 p1 x' y' + p2 (r² + 2 x'²)
///   y'' = y' ρ + p1 (r² + 2 y'²) + 2 p2 x' y'
///   u = fx x'' + cx,  v = fy y'' + cy.
struct Lens {
  int width = 0;                       ///< [px]
  int height = 0;                      ///< [px]
  double fx = 0.0;                     ///< focal length [px]
  double fy = 0.0;                     ///< focal length [px]
  double cx = 0.0;                     ///< principal point [px], pixel centres at integers
  double cy = 0.0;                     ///< principal point [px]
  std::array<double, 8> distortion{};  ///< k1, k2, p1, p2, k3, k4, k5, k6 [dimensionless]

  /// Pixel of a point in the camera's frame; the point must lie before the camera (z > 0).
  Eigen::Vector2d project(const Eigen::Vector3d& point_in_camera) const;

  /// Direction (x', y', 1) in the camera's frame of the ray through a pixel. Newton's method on the
  /// distortion; |project(unproject(p)) - p| < 1e-9 px wherever the distortion is one-to-one.
  /// Beyond that (far outside the image) the result is the last iterate.
  Eigen::Vector3d unproject(const Eigen::Vector2d& pixel) const;

  /// The lens of a part of the picture: pixels are counted from the part's first one.
  Lens of_part(const Region& part) const;

  /// Whether the pixel lies on the sensor, `margin` pixels away from its edge.
  bool contains(const Eigen::Vector2d& pixel, double margin = 0.0) const {
    return pixel.x() >= margin - 0.5 && pixel.y() >= margin - 0.5 &&
           pixel.x() <= width - 0.5 - margin && pixel.y() <= height - 0.5 - margin;
  }
};

/// The distortion alone, normalised (x', y') to (x'', y''); T is double or an automatic derivative.
/// `distortion` in the order of Lens.
template <class T>
Eigen::Matrix<T, 2, 1> distort(const T* distortion, const Eigen::Matrix<T, 2, 1>& normalised) {
  const T& x = normalised.x();
  const T& y = normalised.y();
  const T r2 = x * x + y * y;
  const T radial = (T(1.0) + r2 * (distortion[0] + r2 * (distortion[1] + r2 * distortion[4]))) /
                   (T(1.0) + r2 * (distortion[5] + r2 * (distortion[6] + r2 * distortion[7])));
  return {x * radial + T(2.0) * distortion[2] * x * y + distortion[3] * (r2 + T(2.0) * x * x),
          y * radial + distortion[2] * (r2 + T(2.0) * y * y) + T(2.0) * distortion[3] * x * y};
}

/// d(x'', y'') / d(x', y').
Eigen::Matrix2d distortion_jacobian(const double* distortion, const Eigen::Vector2d& normalised);

/// Lens::project for any scalar; `focal_centre` holds fx, fy, cx, cy.
template <class T>
Eigen::Matrix<T, 2, 1> project(const T* focal_centre, const T* distortion,
                               const Eigen::Matrix<T, 3, 1>& point_in_camera) {
  const Eigen::Matrix<T, 2, 1> normalised(point_in_camera.x() / point_in_camera.z(),
                                          point_in_camera.y() / point_in_camera.z());
  const Eigen::Matrix<T, 2, 1> bent = distort(distortion, normalised);
  return {focal_centre[0] * bent.x() + focal_centre[2],
          focal_centre[1] * bent.y() + focal_centre[3]};
}

}  // namespace kappamu::calib
