// What the detectors of boards share: pictures for OpenCV, measure of blur.
// Included by .cpp files only.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/targets/board_corners.h"
#include "core/image.h"

namespace kappamu::calib {

/// Eight bits between the darkest and brightest per mille, which is what the detectors want.
cv::Mat stretch_to_bytes(const Image<float>& grey);

/// The same picture (of bytes or floats) larger or smaller; pixel centres are at integers in both.
struct ScaledPicture {
  ScaledPicture(const cv::Mat& original, double factor);
  Eigen::Vector2d in_original(const cv::Point2f& point) const;
  Eigen::Vector2d in_scaled(const Eigen::Vector2d& pixel) const;

  cv::Mat pixels;
  double factor;
};

/// Bytes (stretch_to_bytes()) of the picture made `factor` as large. A smaller picture is made
/// before its greys are sorted: of 24 megapixels that takes a tenth of the time.
ScaledPicture scaled_bytes(const Image<float>& grey, double factor);

/// By which a picture of so many pixels is at most `longest_px` long; never above 1.
double reduction(const cv::Mat& picture, int longest_px);

/// OpenCV's view of the same numbers; only read.
cv::Mat view_of(const Image<float>& grey);

/// By a Gaussian of so many pixels.
Image<float> blurred(const Image<float>& grey, double deviation_px);

/// A copy of OpenCV's floats.
Image<float> image_of(const cv::Mat& floats);

std::vector<cv::Point2f> image_points(const std::vector<Eigen::Vector2d>& pixels);

double bilinear(const Image<float>& image, const Eigen::Vector2d& at);

/// Blur of the one edge that the line from a to b crosses: its contrast over its steepest slope is
/// √(2π) standard deviations of a Gaussian.
double profile_blur(const Image<float>& grey, const Eigen::Vector2d& a, const Eigen::Vector2d& b);

/// Between neighbouring corners [px].
double smallest_spacing(const BoardCorners& corners);

/// Distance of each pixel to its nearest fellow.
std::vector<double> nearest_distances(const std::vector<Eigen::Vector2d>& pixels);

}  // namespace kappamu::calib
