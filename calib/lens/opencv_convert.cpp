#include "calib/lens/opencv_convert.h"

#include <cmath>

#include "calib/targets/board_shape.h"

namespace kappamu::calib {

std::array<double, 6> six_of(const cv::Mat& rotation_vector, const cv::Mat& translation) {
  std::array<double, 6> six{};
  for (int i = 0; i < 3; ++i) {
    six[i] = rotation_vector.at<double>(i);
    six[3 + i] = translation.at<double>(i);
  }
  return six;
}

void shorten(std::span<double> numbers) {
  constexpr double steps = 16384.0;
  for (double& number : numbers) {
    int exponent = 0;
    const double mantissa = std::frexp(number, &exponent);
    number = std::ldexp(std::round(steps * mantissa) / steps, exponent);
  }
}

std::vector<cv::Point3f> board_points(const BoardCorners& corners, double square) {
  const BoardShape board{corners.columns, corners.rows, square, corners.staggered};
  std::vector<cv::Point3f> points;
  for (std::size_t k = 0; k < corners.pixels.size(); ++k) {
    const auto [i, j] = corners.place(k);
    const Eigen::Vector3d point = board.flat_point(i, j);
    points.emplace_back(static_cast<float>(point.x()), static_cast<float>(point.y()), 0.0F);
  }
  return points;
}

}  // namespace kappamu::calib
