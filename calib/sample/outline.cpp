#include "calib/sample/outline.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "calib/targets/board_picture.h"
#include "core/error.h"
#include "core/numbers/median.h"

namespace kappamu::calib {
namespace {

InputError not_found(const std::string& name, const std::string& reason) {
  return InputError(name + ": the outline of the sample was not found (" + reason +
                    "); light the face evenly before a dark background, or give its corners in "
                    "corners_px of this sample view in session.json");
}

/// Bright region: a quarter of the way from the background's level to the foreground's, the two
/// being Otsu's classes, so that a face which darkens towards its edges stays whole.
cv::Mat bright_region(const Image<float>& grey) {
  const Image<float> smooth = blurred(grey, 1.0);
  double low = 0.0;
  double high = 0.0;
  cv::minMaxLoc(view_of(smooth), &low, &high);
  cv::Mat bytes;
  const double scale = 255.0 / std::max(high - low, 1e-12);
  view_of(smooth).convertTo(bytes, CV_8U, scale, -low * scale);
  cv::Mat mask;
  cv::threshold(bytes, mask, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  const double foreground = cv::mean(bytes, mask)[0];
  const double background = cv::mean(bytes, 255 - mask)[0];
  cv::threshold(bytes, mask, background + 0.25 * (foreground - background), 255, cv::THRESH_BINARY);
  return mask;
}

Quad in_order(const std::vector<cv::Point>& polygon) {
  std::array<Eigen::Vector2d, 4> corners;
  for (std::size_t k = 0; k < 4; ++k) corners[k] = {polygon[k].x, polygon[k].y};
  double twice_area = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d& a = corners[k];
    const Eigen::Vector2d& b = corners[(k + 1) % 4];
    twice_area += a.x() * b.y() - b.x() * a.y();
  }
  if (twice_area < 0.0) std::reverse(corners.begin(), corners.end());  // y down: now clockwise
  std::size_t first = 0;
  double best = -1.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const double right = (corners[(k + 1) % 4] - corners[k]).normalized().x();
    if (right > best) {
      best = right;
      first = k;
    }
  }
  std::rotate(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(first), corners.end());
  return corners;
}

/// Four-cornered approximation of the hull, the finest one there is.
std::optional<std::vector<cv::Point>> four_corners(const std::vector<cv::Point>& contour) {
  std::vector<cv::Point> hull;
  cv::convexHull(contour, hull);
  const double perimeter = cv::arcLength(hull, true);
  for (double tolerance = 0.005; tolerance < 0.1; tolerance += 0.0025) {
    std::vector<cv::Point> polygon;
    cv::approxPolyDP(hull, polygon, tolerance * perimeter, true);
    if (polygon.size() == 4) return polygon;
    if (polygon.size() < 4) break;
  }
  return std::nullopt;
}

/// Offset along `outward` from `middle` at which the brightness drops fastest, and how fast.
struct Drop {
  double offset = 0.0;
  double slope = 0.0;
};
std::optional<Drop> steepest_drop(const Image<float>& smooth, const Eigen::Vector2d& middle,
                                  const Eigen::Vector2d& outward, double reach) {
  constexpr double step = 0.25;  // pixels; the image is smoothed by 1 px
  const int half = static_cast<int>(std::ceil(reach / step));
  std::vector<double> profile;
  for (int k = -half; k <= half; ++k) {
    const Eigen::Vector2d at = middle + outward * (k * step);
    if (at.x() < 0.0 || at.y() < 0.0 || at.x() >= smooth.width() - 1 ||
        at.y() >= smooth.height() - 1) {
      return std::nullopt;
    }
    profile.push_back(bilinear(smooth, at));
  }
  // Differences over one pixel, so that the bilinear interpolation's kinks do not show.
  constexpr int span = 2;
  const int count = static_cast<int>(profile.size());
  const auto drop_at = [&profile](int k) { return profile[k - span] - profile[k + span]; };
  int best = span + 1;
  for (int k = span + 1; k + span + 1 < count; ++k) {
    if (drop_at(k) > drop_at(best)) best = k;
  }
  // The centre of the drop: its centroid within the blurred step's width, recentred once. It uses
  // all of the step's light, where a parabola through the top uses three noisy differences.
  constexpr int half_width = 12;  // steps: 3 pixels
  double centre = best;
  for (int pass = 0; pass < 3; ++pass) {
    const int middle_step = static_cast<int>(std::lround(centre));
    if (middle_step - half_width < span || middle_step + half_width + span >= count) {
      return std::nullopt;
    }
    double sum = 0.0;
    double moment = 0.0;
    for (int k = middle_step - half_width; k <= middle_step + half_width; ++k) {
      sum += drop_at(k);
      moment += k * drop_at(k);
    }
    if (sum <= 0.0) return std::nullopt;
    centre = moment / sum;
    if (std::abs(centre - best) > half_width) return std::nullopt;
  }
  return Drop{(centre - half) * step, drop_at(best)};
}

}  // namespace

Quad find_bright_quad(const Image<float>& grey, const std::string& name) {
  check(grey.channels() == 1, "find_bright_quad wants a grey image");
  const cv::Mat mask = bright_region(grey);
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  if (contours.empty()) throw not_found(name, "nothing is bright");
  const auto largest = std::max_element(contours.begin(), contours.end(), [](auto& a, auto& b) {
    return cv::contourArea(a) < cv::contourArea(b);
  });
  const double area = cv::contourArea(*largest);
  const cv::Rect box = cv::boundingRect(*largest);
  constexpr double smallest_part_of_image = 0.005;
  if (area < smallest_part_of_image * grey.width() * grey.height()) {
    throw not_found(name, "the largest bright region is tiny");
  }
  if (box.x <= 1 || box.y <= 1 || box.x + box.width >= grey.width() - 1 ||
      box.y + box.height >= grey.height() - 1) {
    throw not_found(name, "the bright region reaches the edge of the picture");
  }
  const auto polygon = four_corners(*largest);
  constexpr double filled = 0.9;  // of the quadrilateral by the region
  if (!polygon || area < filled * cv::contourArea(*polygon)) {
    throw not_found(name, "the bright region is not a quadrilateral");
  }
  return in_order(*polygon);
}

std::vector<std::vector<Eigen::Vector2d>> edge_points(
    const Image<float>& grey, const std::vector<std::vector<Eigen::Vector2d>>& lines,
    double reach) {
  const Image<float> smooth = blurred(grey, 1.0);
  std::vector<std::vector<Eigen::Vector2d>> result;
  for (const std::vector<Eigen::Vector2d>& line : lines) {
    // `line` is a polyline (a straight edge seen through a distorting lens); positions run over it.
    const auto segments = static_cast<double>(line.size() - 1);
    const double length = (line.back() - line.front()).norm();
    const int samples = std::max(8, static_cast<int>(length));
    std::vector<Eigen::Vector2d> points;
    std::vector<double> slopes;
    for (int s = 0; s < samples; ++s) {
      constexpr double left_out = 0.08;
      const double position = segments * (left_out + (1.0 - 2.0 * left_out) * s / (samples - 1.0));
      const auto k = std::min(static_cast<std::size_t>(position), line.size() - 2);
      const Eigen::Vector2d along = line[k + 1] - line[k];
      const Eigen::Vector2d middle = line[k] + (position - static_cast<double>(k)) * along;
      // Clockwise with y down: the inside is to the right of the direction, the outside to its
      // left.
      const Eigen::Vector2d outward = Eigen::Vector2d(along.y(), -along.x()).normalized();
      if (const auto drop = steepest_drop(smooth, middle, outward, reach)) {
        points.emplace_back(middle + outward * drop->offset);
        slopes.push_back(drop->slope);
      }
    }
    // Weak drops are not the edge.
    std::vector<Eigen::Vector2d> kept;
    if (!slopes.empty()) {
      const double median = upper_median(slopes);
      for (std::size_t k = 0; k < points.size(); ++k) {
        if (slopes[k] > 0.3 * median && slopes[k] > 0.0) kept.push_back(points[k]);
      }
    }
    result.push_back(std::move(kept));
  }
  return result;
}

}  // namespace kappamu::calib
