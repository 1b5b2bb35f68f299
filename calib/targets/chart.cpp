#include "calib/targets/chart.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace kappamu::calib {
namespace {

constexpr int chart_columns = 6;
constexpr int chart_rows = 4;

Eigen::Vector2d mapped(const cv::Mat& homography, double x, double y) {
  const auto* h = homography.ptr<double>();
  const double w = h[6] * x + h[7] * y + h[8];
  return {(h[0] * x + h[1] * y + h[2]) / w, (h[3] * x + h[4] * y + h[5]) / w};
}

/// `homography` takes (column, row) of patch centres to pixels.
ChartPatches patches_of(const cv::Mat& homography) {
  // Patches fill about 0.84 of the pitch; the middle half of a patch keeps clear of its blurred
  // rim.
  constexpr double half = 0.21;
  ChartPatches patches;
  for (int row = 0; row < chart_rows; ++row) {
    for (int column = 0; column < chart_columns; ++column) {
      const std::size_t p = static_cast<std::size_t>(row) * chart_columns + column;
      patches.centres[p] = mapped(homography, column, row);
      patches.middles[p] = {mapped(homography, column - half, row - half),
                            mapped(homography, column + half, row - half),
                            mapped(homography, column + half, row + half),
                            mapped(homography, column - half, row + half)};
    }
  }
  return patches;
}

}  // namespace

double luminance_factor(double lightness) {
  // CIE 15:2004: L* = 116 f(Y/Yn) - 16, f cubic root above (6/29)³ and linear below.
  const double f = (lightness + 16.0) / 116.0;
  constexpr double knee = 6.0 / 29.0;
  return f > knee ? f * f * f : 3.0 * knee * knee * (f - 4.0 / 29.0);
}

std::array<double, 6> neutral_reflectances() {
  constexpr std::array<double, 6> lightness{95.19, 81.29, 66.89, 50.76, 35.63, 20.64};
  std::array<double, 6> result{};
  std::transform(lightness.begin(), lightness.end(), result.begin(), luminance_factor);
  return result;
}

std::vector<std::array<int, 2>> pixels_inside(const std::array<Eigen::Vector2d, 4>& corners,
                                              int width, int height) {
  Eigen::Vector2d low = corners[0];
  Eigen::Vector2d high = corners[0];
  double twice_area = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    low = low.cwiseMin(corners[k]);
    high = high.cwiseMax(corners[k]);
    const Eigen::Vector2d& next = corners[(k + 1) % 4];
    twice_area += corners[k].x() * next.y() - next.x() * corners[k].y();
  }
  const double sense = twice_area < 0.0 ? -1.0 : 1.0;
  std::vector<std::array<int, 2>> pixels;
  const int x_end = std::min(width - 1, static_cast<int>(std::floor(high.x())));
  const int y_end = std::min(height - 1, static_cast<int>(std::floor(high.y())));
  for (int y = std::max(0, static_cast<int>(std::ceil(low.y()))); y <= y_end; ++y) {
    for (int x = std::max(0, static_cast<int>(std::ceil(low.x()))); x <= x_end; ++x) {
      bool inside = true;
      for (std::size_t k = 0; k < 4 && inside; ++k) {
        const Eigen::Vector2d edge = corners[(k + 1) % 4] - corners[k];
        const Eigen::Vector2d to = Eigen::Vector2d(x, y) - corners[k];
        inside = sense * (edge.x() * to.y() - edge.y() * to.x()) >= 0.0;
      }
      if (inside) pixels.push_back({x, y});
    }
  }
  return pixels;
}

ChartPatches chart_from_corners(const std::array<Eigen::Vector2d, 4>& corners_px) {
  const std::vector<cv::Point2f> lattice{
      {0, 0}, {chart_columns - 1, 0}, {chart_columns - 1, chart_rows - 1}, {0, chart_rows - 1}};
  std::vector<cv::Point2f> pixels;
  pixels.reserve(corners_px.size());
  for (const Eigen::Vector2d& p : corners_px) {
    pixels.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  return patches_of(cv::getPerspectiveTransform(lattice, pixels));
}

}  // namespace kappamu::calib
