// Conversions between OpenCV's types and ours. Included by .cpp files only.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "calib/lens/lens.h"
#include "calib/lens/pose_numbers.h"
#include "calib/targets/board_corners.h"

namespace kappamu::calib {

inline cv::Mat camera_matrix(const Lens& lens) {
  return (cv::Mat_<double>(3, 3) << lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
}

inline cv::Mat distortion_vector(const Lens& lens) {
  const auto& d = lens.distortion;
  return (cv::Mat_<double>(8, 1) << d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]);
}

std::array<double, 6> six_of(const cv::Mat& rotation_vector, const cv::Mat& translation);

/// To four decimal digits: what OpenCV finds depends in its last digits on where its memory lies,
/// and a start needs no more.
void shorten(std::span<double> numbers);

/// The corners' places on the flat board, in their order.
std::vector<cv::Point3f> board_points(const BoardCorners& corners, double square);

}  // namespace kappamu::calib
