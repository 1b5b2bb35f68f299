#include "calib/targets/board_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace kappamu::calib {

/// Eight bits between the darkest and brightest per mille, which is what the detectors want.
cv::Mat stretch_to_bytes(const Image<float>& grey) {
  std::vector<float> sorted = grey.values();
  const std::size_t cut = sorted.size() / 1000;
  const auto low = sorted.begin() + static_cast<std::ptrdiff_t>(cut);
  const auto high = sorted.end() - 1 - static_cast<std::ptrdiff_t>(cut);
  std::nth_element(sorted.begin(), low, sorted.end());
  const float black = *low;
  std::nth_element(sorted.begin(), high, sorted.end());
  const float white = std::max(*high, black + 1e-6F);
  cv::Mat bytes(grey.height(), grey.width(), CV_8U);
  for (int y = 0; y < grey.height(); ++y) {
    for (int x = 0; x < grey.width(); ++x) {
      const float scaled = 255.0F * (grey(x, y) - black) / (white - black);
      bytes.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(scaled);
    }
  }
  return bytes;
}

ScaledPicture::ScaledPicture(const cv::Mat& original, double factor_)
    : pixels(original), factor(factor_) {
  if (factor == 1.0) return;
  cv::resize(original, pixels, cv::Size(), factor, factor,
             factor < 1.0 ? cv::INTER_AREA : cv::INTER_CUBIC);
}

Eigen::Vector2d ScaledPicture::in_original(const cv::Point2f& point) const {
  return {(point.x + 0.5) / factor - 0.5, (point.y + 0.5) / factor - 0.5};
}

Eigen::Vector2d ScaledPicture::in_scaled(const Eigen::Vector2d& pixel) const {
  return ((pixel.array() + 0.5) * factor - 0.5).matrix();
}

ScaledPicture scaled_bytes(const Image<float>& grey, double factor) {
  if (factor >= 1.0) return {stretch_to_bytes(grey), factor};
  ScaledPicture picture(view_of(grey), factor);
  picture.pixels = stretch_to_bytes(image_of(picture.pixels));
  return picture;
}

double reduction(const cv::Mat& picture, int longest_px) {
  return std::min(1.0, static_cast<double>(longest_px) / std::max(picture.cols, picture.rows));
}

cv::Mat view_of(const Image<float>& grey) {
  return {grey.height(), grey.width(), CV_32F, const_cast<float*>(grey.values().data())};
}

Image<float> blurred(const Image<float>& grey, double deviation_px) {
  Image<float> smooth(grey.width(), grey.height(), 1);
  cv::GaussianBlur(view_of(grey), view_of(smooth), cv::Size(), deviation_px);
  return smooth;
}

Image<float> image_of(const cv::Mat& floats) {
  Image<float> image(floats.cols, floats.rows, 1);
  floats.copyTo(view_of(image));
  return image;
}

std::vector<cv::Point2f> image_points(const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<cv::Point2f> points;
  points.reserve(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels) {
    points.emplace_back(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
  }
  return points;
}

double bilinear(const Image<float>& image, const Eigen::Vector2d& at) {
  const int x = std::clamp(static_cast<int>(std::floor(at.x())), 0, image.width() - 2);
  const int y = std::clamp(static_cast<int>(std::floor(at.y())), 0, image.height() - 2);
  const double fx = at.x() - x;
  const double fy = at.y() - y;
  return (1.0 - fy) * ((1.0 - fx) * image(x, y) + fx * image(x + 1, y)) +
         fy * ((1.0 - fx) * image(x, y + 1) + fx * image(x + 1, y + 1));
}

double profile_blur(const Image<float>& grey, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const double length = (b - a).norm();
  constexpr double step = 0.25;  // pixels
  std::vector<double> profile;
  for (double s = 0.0; s <= length; s += step) {
    profile.push_back(bilinear(grey, a + (b - a) * (s / length)));
  }
  constexpr std::size_t span = 2;
  double steepest = 0.0;
  for (std::size_t k = span; k + span < profile.size(); ++k) {
    steepest = std::max(steepest, std::abs(profile[k + span] - profile[k - span]));
  }
  const auto [low, high] = std::minmax_element(profile.begin(), profile.end());
  if (steepest <= 0.0) return 0.0;
  constexpr double root_two_pi = 2.5066;
  return (*high - *low) * 2.0 * span * step / steepest / root_two_pi;
}

double smallest_spacing(const BoardCorners& corners) {
  const std::vector<double> nearest = nearest_distances(corners.pixels);
  return *std::min_element(nearest.begin(), nearest.end());
}

std::vector<double> nearest_distances(const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<double> distances(pixels.size(), std::numeric_limits<double>::infinity());
  for (std::size_t a = 0; a < pixels.size(); ++a) {
    for (std::size_t b = 0; b < pixels.size(); ++b) {
      if (a != b) distances[a] = std::min(distances[a], (pixels[a] - pixels[b]).norm());
    }
  }
  return distances;
}

}  // namespace kappamu::calib
