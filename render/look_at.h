// The frame of a camera or projector that stands at a point and looks at another: rays through its
// image plane, and back.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace kappamu::render {

/// Image coordinates (x, y) in [0, 1]², from the top left corner. The image is `aspect` times as
/// wide as high.
class LookAt {
 public:
  LookAt(const Eigen::Vector3d& position, const Eigen::Vector3d& target, const Eigen::Vector3d& up,
         double fov_deg, double aspect)
      : position_(position), aspect_(aspect) {
    forward_ = (target - position).normalized();
    right_ = forward_.cross(up).normalized();
    up_ = right_.cross(forward_);
    half_height_ = std::tan(0.5 * fov_deg * std::numbers::pi / 180.0);
  }

  const Eigen::Vector3d& position() const { return position_; }
  const Eigen::Vector3d& forward() const { return forward_; }

  /// Direction of the ray through (x, y), of unit length.
  Eigen::Vector3d direction(double x, double y) const {
    return (forward_ + (2.0 * x - 1.0) * half_height_ * aspect_ * right_ +
            (1.0 - 2.0 * y) * half_height_ * up_)
        .normalized();
  }

  /// Where the ray along `direction` meets the image plane; false behind or beside the image.
  bool image_point(const Eigen::Vector3d& direction, double& x, double& y) const {
    const double depth = direction.dot(forward_);
    if (depth <= 0.0) return false;
    x = 0.5 * (1.0 + direction.dot(right_) / (depth * half_height_ * aspect_));
    y = 0.5 * (1.0 - direction.dot(up_) / (depth * half_height_));
    return x >= 0.0 && x < 1.0 && y >= 0.0 && y < 1.0;
  }

 private:
  Eigen::Vector3d position_, forward_, right_, up_;
  double half_height_ = 1.0, aspect_ = 1.0;
};

}  // namespace kappamu::render
