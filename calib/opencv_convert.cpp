#include "calib/opencv_convert.h"

namespace kappamu::calib {

std::array<double, 6> six_of(const cv::Mat& rotation_vector, const cv::Mat& translation) {
  std::array<double, 6> six{};
  for (int i = 0; i < 3; ++i) {
    six[i] = rotation_vector.at<double>(i);
    six[3 + i] = translation.at<double>(i);
  }
  return six;
}

std::array<double, 6> six_of(const Rigid& motion) {
  const Eigen::AngleAxisd turn(motion.rotation);
  const Eigen::Vector3d vector = turn.angle() * turn.axis();
  const Eigen::Vector3d& t = motion.translation;
  return {vector.x(), vector.y(), vector.z(), t.x(), t.y(), t.z()};
}

Rigid rigid_of(const std::array<double, 6>& six) {
  const Eigen::Vector3d vector(six[0], six[1], six[2]);
  const double angle = vector.norm();
  Rigid motion;
  if (angle > 0.0) motion.rotation = Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
  motion.translation = {six[3], six[4], six[5]};
  return motion;
}

std::vector<cv::Point3f> board_points(int columns, int rows, double square) {
  std::vector<cv::Point3f> points;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      points.emplace_back(static_cast<float>(square * i), static_cast<float>(square * j), 0.0F);
    }
  }
  return points;
}

std::vector<cv::Point2f> image_points(const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<cv::Point2f> points;
  points.reserve(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels) {
    points.emplace_back(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
  }
  return points;
}

}  // namespace kappamu::calib
