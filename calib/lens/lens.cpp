#include "calib/lens/lens.h"

#include <Eigen/LU>

namespace kappamu::calib {

Eigen::Vector2d Lens::project(const Eigen::Vector3d& point_in_camera) const {
  const std::array<double, 4> focal_centre{fx, fy, cx, cy};
  return calib::project<double>(focal_centre.data(), distortion.data(), point_in_camera);
}

Lens Lens::of_part(const Region& part) const {
  Lens lens = *this;
  lens.width = part.width;
  lens.height = part.height;
  lens.cx -= part.left;
  lens.cy -= part.top;
  return lens;
}

Eigen::Matrix2d distortion_jacobian(const double* distortion, const Eigen::Vector2d& normalised) {
  const double k1 = distortion[0];
  const double k2 = distortion[1];
  const double p1 = distortion[2];
  const double p2 = distortion[3];
  const double k3 = distortion[4];
  const double k4 = distortion[5];
  const double k5 = distortion[6];
  const double k6 = distortion[7];
  const double x = normalised.x();
  const double y = normalised.y();
  const double r2 = x * x + y * y;
  const double below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
  const double radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / below;
  // d(radial)/d(r²), so that d(radial)/dx = 2 x slope.
  const double slope =
      (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3) - radial * (k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6))) /
      below;
  Eigen::Matrix2d jacobian;
  jacobian(0, 0) = radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
  jacobian(0, 1) = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
  jacobian(1, 0) = jacobian(0, 1);
  jacobian(1, 1) = radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
  return jacobian;
}

Eigen::Vector3d Lens::unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d target((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  Eigen::Vector2d p = target;
  // Rounding of the residual in normalised units; far below 1e-9 px for any focal length in use.
  constexpr double converged = 1e-15;
  constexpr int max_iterations = 30;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const Eigen::Vector2d residual = distort<double>(distortion.data(), p) - target;
    if (residual.norm() <= converged) break;
    const Eigen::Matrix2d jacobian = distortion_jacobian(distortion.data(), p);
    const double determinant = jacobian.determinant();
    if (std::abs(determinant) < 1e-12) break;  // at the fold of the distortion
    p -= jacobian.inverse() * residual;
  }
  return {p.x(), p.y(), 1.0};
}

}  // namespace kappamu::calib
