#include "calib/sinusoid/local_noise.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kappamu::calib {

Image<float> local_noise(const Image<float>& picture, const Image<std::uint8_t>& mask) {
  const int width = picture.width(), height = picture.height();
  cv::Mat squares = cv::Mat::zeros(height, width, CV_64F), count = squares.clone();
  for (int y = 1; y + 1 < height; ++y) {
    for (int x = 1; x + 1 < width; ++x) {
      double difference = 0.0;
      bool whole = true;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const double weight = (dx == 0 ? -2.0 : 1.0) * (dy == 0 ? -2.0 : 1.0);
          difference += weight * picture(x + dx, y + dy);
          whole = whole && mask(x + dx, y + dy) != 0;
        }
      }
      if (!whole) continue;
      squares.at<double>(y, x) = difference * difference / 36.0;  // Σ weight² = 36
      count.at<double>(y, x) = 1.0;
    }
  }
  for (cv::Mat* sum : {&squares, &count}) {
    cv::boxFilter(*sum, *sum, -1, {9, 9}, {-1, -1}, false, cv::BORDER_CONSTANT);
  }
  Image<float> result(width, height, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double n = count.at<double>(y, x);
      if (n > 0.0) result(x, y) = static_cast<float>(std::sqrt(squares.at<double>(y, x) / n));
    }
  }
  return result;
}

Image<float> smoothed(const Image<float>& picture, const Image<std::uint8_t>& mask, double sigma) {
  const int width = picture.width(), height = picture.height();
  cv::Mat sum = cv::Mat::zeros(height, width, CV_32F), weight = sum.clone();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (mask(x, y) == 0) continue;
      sum.at<float>(y, x) = picture(x, y);
      weight.at<float>(y, x) = 1.0F;
    }
  }
  const int taps = 2 * static_cast<int>(std::ceil(3.5 * sigma)) + 1;
  for (cv::Mat* plane : {&sum, &weight}) {
    cv::GaussianBlur(*plane, *plane, {taps, taps}, sigma, sigma, cv::BORDER_CONSTANT);
  }
  Image<float> result(width, height, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (weight.at<float>(y, x) > 0.0F) {
        result(x, y) = sum.at<float>(y, x) / weight.at<float>(y, x);
      }
    }
  }
  return result;
}

}  // namespace kappamu::calib
