#include "calib/targets/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace kappamu::calib {
namespace {

constexpr int columns = 6;
constexpr int rows = 4;

struct Candidate {
  Eigen::Vector2d centre;
  double area = 0.0;
};

InputError not_found(const std::string& name) {
  return InputError(name +
                    ": no colour chart found; show all 24 patches, sharp and upright, or give the "
                    "centres of its corner patches in calibration.colour_chart.corners_px of "
                    "session.json");
}

/// Squarish quadrilaterals brighter than a threshold, over many thresholds.
std::vector<Candidate> squares(const Image<float>& grey) {
  const cv::Mat image(grey.height(), grey.width(), CV_32F,
                      const_cast<float*>(grey.values().data()));  // OpenCV's view; only read
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, cv::Size(), 1.0);
  double brightest = 0.0;
  cv::minMaxLoc(smooth, nullptr, &brightest);
  const double smallest_area = 25.0;
  const double largest_area = 0.04 * grey.width() * grey.height();
  std::vector<Candidate> found;
  for (double threshold = 0.02 * brightest; threshold < 0.9 * brightest; threshold *= 1.15) {
    const cv::Mat mask = smooth > threshold;
    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(mask, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    for (const auto& contour : contours) {
      const double area = cv::contourArea(contour);
      if (area < smallest_area || area > largest_area) continue;
      const cv::RotatedRect box = cv::minAreaRect(contour);
      const double wide = std::max(box.size.width, box.size.height);
      const double narrow = std::min(box.size.width, box.size.height);
      constexpr double slimmest = 0.6;
      constexpr double emptiest = 0.8;
      if (narrow < slimmest * wide || area < emptiest * wide * narrow) continue;
      const cv::Moments moments = cv::moments(contour);
      found.push_back({{moments.m10 / moments.m00, moments.m01 / moments.m00}, area});
    }
  }
  return found;
}

/// One candidate per place, of about the commonest size.
std::vector<Candidate> distinct(std::vector<Candidate> found) {
  if (found.empty()) return found;
  std::vector<double> areas;
  areas.reserve(found.size());
  for (const Candidate& c : found) areas.push_back(c.area);
  std::nth_element(areas.begin(), areas.begin() + static_cast<std::ptrdiff_t>(areas.size() / 2),
                   areas.end());
  const double typical = areas[areas.size() / 2];
  std::erase_if(
      found, [&](const Candidate& c) { return c.area < 0.4 * typical || c.area > 2.0 * typical; });
  std::vector<Candidate> kept;
  std::vector<int> counts;
  for (const Candidate& c : found) {
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const Candidate& k) {
      return (k.centre - c.centre).norm() < 0.4 * std::sqrt(typical);
    });
    if (same == kept.end()) {
      kept.push_back(c);
      counts.push_back(1);
    } else {
      const auto i = same - kept.begin();
      same->centre = (same->centre * counts[i] + c.centre) / (counts[i] + 1);
      ++counts[i];
    }
  }
  return kept;
}

enum class Direction { right, down };

/// Middle of the nearest-neighbour steps that point most to the right or, turned, most downwards.
std::optional<Eigen::Vector2d> lattice_step(const std::vector<Candidate>& squares_found,
                                            Direction direction) {
  std::vector<Eigen::Vector2d> steps;
  for (const Candidate& from : squares_found) {
    double nearest = std::numeric_limits<double>::infinity();
    Eigen::Vector2d step = Eigen::Vector2d::Zero();
    for (const Candidate& to : squares_found) {
      const Eigen::Vector2d d = to.centre - from.centre;
      const double along = direction == Direction::down ? d.y() : d.x();
      const double across = direction == Direction::down ? d.x() : d.y();
      if (along > std::abs(across) && d.norm() < nearest) {
        nearest = d.norm();
        step = d;
      }
    }
    if (std::isfinite(nearest)) steps.push_back(step);
  }
  if (steps.size() < 4) return std::nullopt;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end(),
                   [](const auto& a, const auto& b) { return a.norm() < b.norm(); });
  return *middle;
}

struct Lattice {
  std::vector<std::array<int, 2>> index;  ///< column and row of each candidate in it
  std::vector<Eigen::Vector2d> centre;
  int width = 0;
  int height = 0;
};

/// Walks from square to square by the lattice's steps, taking up the largest connected set.
Lattice walk(const std::vector<Candidate>& all, const Eigen::Vector2d& right,
             const Eigen::Vector2d& down) {
  Lattice best;
  for (std::size_t start = 0; start < all.size(); ++start) {
    std::map<std::size_t, std::array<int, 2>> index{{start, {0, 0}}};
    std::vector<std::size_t> open{start};
    while (!open.empty()) {
      const std::size_t from = open.back();
      open.pop_back();
      const std::array<int, 2> here = index.at(from);
      for (const auto& [dx, dy] :
           {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
        const Eigen::Vector2d step = dx * right + dy * down;
        const Eigen::Vector2d guess = all[from].centre + step;
        for (std::size_t k = 0; k < all.size(); ++k) {
          if (index.contains(k) || (all[k].centre - guess).norm() > 0.3 * step.norm()) continue;
          index[k] = {here[0] + dx, here[1] + dy};
          open.push_back(k);
        }
      }
    }
    if (index.size() <= best.index.size()) continue;
    best = {};
    std::array<int, 2> low{0, 0};
    std::array<int, 2> high{0, 0};
    for (const auto& [k, at] : index) {
      for (int axis = 0; axis < 2; ++axis) {
        low[axis] = std::min(low[axis], at[axis]);
        high[axis] = std::max(high[axis], at[axis]);
      }
    }
    for (const auto& [k, at] : index) {
      best.index.push_back({at[0] - low[0], at[1] - low[1]});
      best.centre.push_back(all[k].centre);
    }
    best.width = high[0] - low[0] + 1;
    best.height = high[1] - low[1] + 1;
  }
  return best;
}

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
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::size_t p = static_cast<std::size_t>(row) * columns + column;
      patches.centres[p] = mapped(homography, column, row);
      patches.middles[p] = {mapped(homography, column - half, row - half),
                            mapped(homography, column + half, row - half),
                            mapped(homography, column + half, row + half),
                            mapped(homography, column - half, row + half)};
    }
  }
  return patches;
}

/// Index of the patch at lattice (x, y) after `turn` quarter turns.
std::array<int, 2> turned(const std::array<int, 2>& at, int turn, int width, int height) {
  switch (turn) {
    case 1:
      return {at[1], width - 1 - at[0]};
    case 2:
      return {width - 1 - at[0], height - 1 - at[1]};
    case 3:
      return {height - 1 - at[1], at[0]};
    default:
      return at;
  }
}

double mean_inside(const Image<float>& grey, const std::array<Eigen::Vector2d, 4>& corners) {
  double sum = 0.0;
  const auto pixels = pixels_inside(corners, grey.width(), grey.height());
  for (const auto& [x, y] : pixels) sum += grey(x, y);
  return pixels.empty() ? 0.0 : sum / static_cast<double>(pixels.size());
}

/// Mean squared difference of ln brightness and ln reflectance of the neutrals, scale removed.
double neutral_mismatch(const Image<float>& grey, const ChartPatches& patches) {
  const std::array<double, 6> published = neutral_reflectances();
  std::array<double, 6> difference{};
  double mean = 0.0;
  for (std::size_t k = 0; k < 6; ++k) {
    const double seen = std::max(mean_inside(grey, patches.middles[18 + k]), 1e-9);
    difference[k] = std::log(seen / published[k]);
    mean += difference[k] / 6.0;
  }
  double sum = 0.0;
  for (const double d : difference) sum += (d - mean) * (d - mean);
  return sum / 6.0;
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
      {0, 0}, {columns - 1, 0}, {columns - 1, rows - 1}, {0, rows - 1}};
  std::vector<cv::Point2f> pixels;
  pixels.reserve(corners_px.size());
  for (const Eigen::Vector2d& p : corners_px) {
    pixels.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  return patches_of(cv::getPerspectiveTransform(lattice, pixels));
}

ChartPatches find_chart(const Image<float>& grey, const std::string& name) {
  check(grey.channels() == 1, "find_chart wants a grey image");
  const std::vector<Candidate> candidates = distinct(squares(grey));
  const auto right = lattice_step(candidates, Direction::right);
  const auto down = lattice_step(candidates, Direction::down);
  if (!right || !down) throw not_found(name);
  const Lattice lattice = walk(candidates, *right, *down);
  const bool lying = lattice.width == columns && lattice.height == rows;
  const bool standing = lattice.width == rows && lattice.height == columns;
  constexpr std::size_t fewest = 14;  // of 24; the lattice's extent then is hardly an accident
  if ((!lying && !standing) || lattice.index.size() < fewest) throw not_found(name);

  ChartPatches best;
  double least = std::numeric_limits<double>::infinity();
  for (const int turn : lying ? std::array{0, 2} : std::array{1, 3}) {
    std::vector<cv::Point2f> from;
    std::vector<cv::Point2f> to;
    for (std::size_t k = 0; k < lattice.index.size(); ++k) {
      const auto at = turned(lattice.index[k], turn, lattice.width, lattice.height);
      from.emplace_back(static_cast<float>(at[0]), static_cast<float>(at[1]));
      to.emplace_back(static_cast<float>(lattice.centre[k].x()),
                      static_cast<float>(lattice.centre[k].y()));
    }
    const cv::Mat homography = cv::findHomography(from, to, 0);
    if (homography.empty()) continue;
    ChartPatches patches = patches_of(homography);
    patches.found = static_cast<int>(lattice.index.size());
    const double mismatch = neutral_mismatch(grey, patches);
    if (mismatch < least) {
      least = mismatch;
      best = patches;
    }
  }
  constexpr double worst_mismatch = 0.1;  // of squared ln: 30 % scatter of the neutrals
  if (least > worst_mismatch) throw not_found(name);
  return best;
}

}  // namespace kappamu::calib
