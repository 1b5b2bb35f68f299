#include "calib/projector/projector_map.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>

#include "calib/targets/board_picture.h"
#include "core/error.h"
#include "core/numbers/linear_algebra.h"
#include "core/numbers/median.h"

namespace kappamu::calib {
namespace {

constexpr std::size_t least_cell_px = 40;
constexpr std::size_t least_quadrant_px = 5;
constexpr double outlier_px = 1.5;  // of the projector: codes are right to half a pixel or wrong
constexpr std::size_t least_points = 12;
constexpr int lattice_columns = 24;

struct Sample {
  cv::Point2f camera;
  cv::Point2f projector;  // from the cell's middle
};

/// Where in the camera's picture the middle of the cell is.
std::optional<Eigen::Vector2d> locate(const std::vector<Sample>& samples) {
  if (samples.size() < least_cell_px) return std::nullopt;
  std::array<std::size_t, 4> quadrants{};
  cv::Point2f mean(0.0F, 0.0F);
  for (const Sample& s : samples) {
    ++quadrants[(s.projector.x > 0.0F ? 1U : 0U) + (s.projector.y > 0.0F ? 2U : 0U)];
    mean += s.camera * (1.0F / static_cast<float>(samples.size()));
  }
  if (*std::min_element(quadrants.begin(), quadrants.end()) < least_quadrant_px) {
    return std::nullopt;
  }
  std::vector<cv::Point2f> from;
  std::vector<cv::Point2f> to;
  for (const Sample& s : samples) {
    from.push_back(s.camera - mean);
    to.push_back(s.projector);
  }
  std::vector<std::uint8_t> inliers;
  const cv::Mat found = cv::findHomography(from, to, cv::RANSAC, outlier_px, inliers);
  if (found.empty()) return std::nullopt;
  constexpr double most = 0.7;
  if (std::count(inliers.begin(), inliers.end(), 1) < most * static_cast<double>(from.size())) {
    return std::nullopt;
  }
  Eigen::Matrix3d homography;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) homography(r, c) = found.at<double>(r, c);
  }
  const Eigen::Vector3d middle = homography.inverse() * Eigen::Vector3d::UnitZ();
  return Eigen::Vector2d(mean.x + middle.x() / middle.z(), mean.y + middle.y() / middle.z());
}

template <class T>
std::vector<T> chosen_of(const std::vector<T>& all, const std::vector<std::uint8_t>& chosen) {
  std::vector<T> result;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (chosen[k] != 0) result.push_back(all[k]);
  }
  return result;
}

/// Unchooses points further than five median residuals (0.4 px at least) from a quadratic
/// correction of the homography, which is what distortion needs: at the plane's edge half a cell
/// lies on what is behind.
void drop_odd_points(const std::vector<cv::Point2f>& shown, const std::vector<cv::Point2f>& seen,
                     std::vector<std::uint8_t>& chosen) {
  constexpr int passes = 4;
  for (int pass = 0; pass < passes; ++pass) {
    std::vector<std::size_t> all(chosen.size());
    std::iota(all.begin(), all.end(), 0U);
    const std::vector<std::size_t> in = chosen_of(all, chosen);
    const std::vector<cv::Point2f> from = chosen_of(shown, chosen), to = chosen_of(seen, chosen);
    if (in.size() < least_points) return;
    const cv::Mat view = cv::findHomography(from, to, 0);
    if (view.empty()) return;
    std::vector<cv::Point2f> expected;
    cv::perspectiveTransform(from, expected, view);
    const auto rows = static_cast<Eigen::Index>(in.size());
    Eigen::MatrixXd terms(rows, 6);
    Eigen::MatrixXd residuals(rows, 2);
    for (Eigen::Index r = 0; r < rows; ++r) {
      const cv::Point2f& p = from[static_cast<std::size_t>(r)];
      terms.row(r) << 1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y;
      const cv::Point2f miss =
          to[static_cast<std::size_t>(r)] - expected[static_cast<std::size_t>(r)];
      residuals.row(r) << miss.x, miss.y;
    }
    residuals -= terms * least_squares(terms, residuals);
    std::vector<double> sizes(in.size());
    for (Eigen::Index r = 0; r < rows; ++r) {
      sizes[static_cast<std::size_t>(r)] = residuals.row(r).norm();
    }
    constexpr double smallest_px = 0.4;
    const double bound = std::max(smallest_px, 5.0 * upper_median(sizes));
    bool dropped = false;
    for (std::size_t r = 0; r < in.size(); ++r) {
      if (sizes[r] <= bound) continue;
      chosen[in[r]] = 0;
      dropped = true;
    }
    if (!dropped) return;
  }
}

}  // namespace

double ProjectorMap::legible_share() const {
  const auto legible = std::count_if(quality.values().begin(), quality.values().end(),
                                     [](float value) { return value > 0.0F; });
  return static_cast<double>(legible) / static_cast<double>(quality.size());
}

Image<float> block_means(const Image<float>& map, int longest) {
  const int block = (std::max(map.width(), map.height()) + longest - 1) / longest;
  Image<float> means(map.width() / block, map.height() / block, 1);
  for (int y = 0; y < means.height(); ++y) {
    for (int x = 0; x < means.width(); ++x) {
      double sum = 0.0;
      for (int k = 0; k < block * block; ++k) {
        sum += map(x * block + k % block, y * block + k / block);
      }
      means(x, y) = static_cast<float>(sum / (block * block));
    }
  }
  return means;
}

capture::ProjectedBoard map_lattice(const capture::Projector& projector) {
  capture::ProjectedBoard lattice;
  lattice.square_px = std::floor(static_cast<double>(projector.width) / (lattice_columns + 1));
  lattice.columns = lattice_columns;
  lattice.rows = std::max(3, static_cast<int>(projector.height / lattice.square_px) - 1);
  lattice.origin_px = {0.5 * (projector.width - 1 - lattice.square_px * (lattice.columns - 1)),
                       0.5 * (projector.height - 1 - lattice.square_px * (lattice.rows - 1))};
  return lattice;
}

BoardCorners mapped_corners(const ProjectorMap& map, const capture::ProjectedBoard& lattice,
                            const std::string& name) {
  std::vector<std::vector<Sample>> cells(static_cast<std::size_t>(lattice.columns) * lattice.rows);
  for (int y = 0; y < map.quality.height(); ++y) {
    for (int x = 0; x < map.quality.width(); ++x) {
      if (map.quality(x, y) <= 0.0F) continue;
      const double u = map.pixel(x, y, 0) - lattice.origin_px[0];
      const double v = map.pixel(x, y, 1) - lattice.origin_px[1];
      const auto i = static_cast<int>(std::lround(u / lattice.square_px));
      const auto j = static_cast<int>(std::lround(v / lattice.square_px));
      if (i < 0 || j < 0 || i >= lattice.columns || j >= lattice.rows) continue;
      cells[static_cast<std::size_t>(j) * lattice.columns + i].push_back(
          {cv::Point2f(static_cast<float>(x), static_cast<float>(y)),
           cv::Point2f(static_cast<float>(u - lattice.square_px * i),
                       static_cast<float>(v - lattice.square_px * j))});
    }
  }
  BoardCorners corners{lattice.columns, lattice.rows, {}};
  std::set<int> columns;
  std::set<int> rows;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const auto place = locate(cells[k]);
    if (!place) continue;
    corners.pixels.push_back(*place);
    corners.lattice.push_back(static_cast<int>(k));
    columns.insert(static_cast<int>(k) % lattice.columns);
    rows.insert(static_cast<int>(k) / lattice.columns);
  }
  if (corners.pixels.size() < least_points || columns.size() < 3 || rows.size() < 3) {
    throw InputError(name + ": the code is legible in " +
                     std::to_string(static_cast<int>(std::lround(100.0 * map.legible_share()))) +
                     " % of the picture and locates " + std::to_string(corners.pixels.size()) +
                     " of " + std::to_string(cells.size()) +
                     " points, at least 12 are needed; photograph the plane again with the room "
                     "light off, the projector in focus and its white below saturation, or take "
                     "the plane out of session.json");
  }
  return corners;
}

BoardCorners points_on_plane(const BoardCorners& points, const BoardCorners& printed, int width_px,
                             const std::string& name) {
  const double tolerance = 0.006 * width_px;
  std::vector<cv::Point2f> shown;
  for (std::size_t k = 0; k < points.pixels.size(); ++k) {
    const auto [i, j] = points.place(k);
    shown.emplace_back(static_cast<float>(i), static_cast<float>(j));
  }
  const std::vector<cv::Point2f> seen = image_points(points.pixels);
  std::vector<cv::Point2f> hull;
  cv::convexHull(image_points(printed.pixels), hull);
  std::vector<std::uint8_t> chosen(points.pixels.size(), 0);
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    chosen[k] = cv::pointPolygonTest(hull, seen[k], false) > 0.0 ? 1 : 0;
  }
  const auto count = [&chosen] {
    return static_cast<std::size_t>(std::count(chosen.begin(), chosen.end(), 1));
  };
  if (count() < least_points) {
    if (cv::findHomography(shown, seen, cv::RANSAC, tolerance, chosen).empty()) {
      std::fill(chosen.begin(), chosen.end(), 0);
    }
  }
  constexpr int passes = 8;
  for (int pass = 0; pass < passes && count() >= least_points; ++pass) {
    // Robust, should the printed board's outline contain something before it.
    const cv::Mat view = cv::findHomography(chosen_of(shown, chosen), chosen_of(seen, chosen),
                                            cv::RANSAC, tolerance);
    if (view.empty()) break;
    std::vector<cv::Point2f> expected;
    cv::perspectiveTransform(shown, expected, view);
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      chosen[k] = cv::norm(expected[k] - seen[k]) < tolerance ? 1 : 0;
    }
  }
  if (count() < least_points) {
    throw InputError(name + ": only " + std::to_string(count()) + " of " +
                     std::to_string(points.pixels.size()) +
                     " points of the code lie on one plane, at least 12 are needed; hold a "
                     "larger plane into the projector's light, or take the plane out of "
                     "session.json");
  }
  drop_odd_points(shown, seen, chosen);
  BoardCorners result{points.columns, points.rows, {}};
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (chosen[k] == 0) continue;
    result.pixels.push_back(points.pixels[k]);
    const auto [i, j] = points.place(k);
    result.lattice.push_back(j * points.columns + i);
  }
  return result;
}

}  // namespace kappamu::calib
