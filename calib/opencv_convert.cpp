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
