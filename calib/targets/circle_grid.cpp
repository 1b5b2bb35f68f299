#include "calib/targets/circle_grid.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>

#include "calib/targets/board_picture.h"
#include "calib/targets/dot_lattice.h"
#include "core/error.h"
#include "core/numbers/linear_algebra.h"
#include "core/numbers/median.h"

namespace kappamu::calib {
namespace {

using Eigen::Vector2d;

cv::Ptr<cv::FeatureDetector> dot_detector(const cv::Mat& bytes, const capture::Board& board) {
  cv::SimpleBlobDetector::Params params;
  const double pixels = static_cast<double>(bytes.total());
  params.minArea = 12.0F;
  // No dot covers more than its share of a picture that the grid fills.
  params.maxArea = static_cast<float>(pixels / (board.columns * board.rows));
  params.minDistBetweenBlobs = 4.0F;
  return cv::SimpleBlobDetector::create(params);
}

/// Dark-weighted centroid about `start`; the background is a plane through the window's rim.
Vector2d centroid(const Image<float>& grey, const Vector2d& start, double radius) {
  const int x0 = std::max(0, static_cast<int>(std::ceil(start.x() - radius)));
  const int x1 = std::min(grey.width() - 1, static_cast<int>(std::floor(start.x() + radius)));
  const int y0 = std::max(0, static_cast<int>(std::ceil(start.y() - radius)));
  const int y1 = std::min(grey.height() - 1, static_cast<int>(std::floor(start.y() + radius)));
  constexpr double rim = 0.85;              // of the radius: outside, there is background only
  std::vector<Eigen::Vector4d> background;  // 1, x, y, value
  const auto each = [&](const auto& act) {
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const Vector2d offset = Vector2d(x, y) - start;
        if (offset.norm() <= radius) act(offset, grey(x, y));
      }
    }
  };
  each([&](const Vector2d& offset, double value) {
    if (offset.norm() >= rim * radius) background.push_back({1.0, offset.x(), offset.y(), value});
  });
  if (background.size() < 8) return start;
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(background.size()), 4);
  for (std::size_t k = 0; k < background.size(); ++k) {
    rows.row(static_cast<Eigen::Index>(k)) = background[k];
  }
  const Eigen::Vector3d plane = least_squares(rows.leftCols<3>(), rows.col(3));
  double weight = 0.0;
  Vector2d sum = Vector2d::Zero();
  each([&](const Vector2d& offset, double value) {
    const double dark = plane.dot(Eigen::Vector3d(1.0, offset.x(), offset.y())) - value;
    weight += dark;
    sum += dark * offset;
  });
  return weight > 0.0 ? Vector2d(start + sum / weight) : start;
}

void refine(const Image<float>& grey, std::vector<Vector2d>& pixels) {
  constexpr double reach = 0.5;  // of the way to the next dot
  constexpr int passes = 3;      // the window follows the centre
  for (int pass = 0; pass < passes; ++pass) {
    const std::vector<double> nearest = nearest_distances(pixels);
    for (std::size_t k = 0; k < pixels.size(); ++k) {
      pixels[k] = centroid(grey, pixels[k], reach * nearest[k]);
    }
  }
}

Image<float> negative(const Image<float>& grey) {
  Image<float> result = grey;
  for (float& value : result.values()) value = -value;
  return result;
}

/// Dark dots of the picture reduced so, in pixels of the whole one.
std::vector<Vector2d> dark_dots(const Image<float>& grey, const capture::Board& board,
                                double factor) {
  const ScaledPicture picture = scaled_bytes(grey, factor);
  std::vector<cv::KeyPoint> seen;
  dot_detector(picture.pixels, board)->detect(picture.pixels, seen);
  std::vector<Vector2d> dots;
  for (const cv::KeyPoint& dot : seen) dots.push_back(picture.in_original(dot.pt));
  return dots;
}

DotSearch search_dots(const Image<float>& grey, const capture::Board& board, std::size_t& seen) {
  const DotGrid wanted{board.columns, board.rows,
                       board.kind == capture::BoardKind::asymmetric_circles};
  constexpr int longest_px = 1600;
  const double factor = reduction(view_of(grey), longest_px);
  const std::vector<Vector2d> dots = dark_dots(grey, board, factor);
  seen = dots.size();
  const DotSearch search = find_dot_grid(dots, wanted);
  if (!search.grid.empty() || search.other || factor == 1.0) return search;
  const std::vector<Vector2d> small_ones = dark_dots(grey, board, 1.0);
  seen = small_ones.size();
  return find_dot_grid(small_ones, wanted);
}

std::string named(const DotGrid& grid) {
  return std::string(grid.staggered ? "asymmetric " : "") + "circle grid of " +
         std::to_string(grid.columns) + " x " + std::to_string(grid.rows) + " dots";
}

}  // namespace

BoardCorners find_circles(const Image<float>& grey, const capture::Board& board,
                          const std::string& name) {
  check(grey.channels() == 1, "find_circles wants a grey image");
  BoardCorners corners{board.columns, board.rows, {}};
  corners.staggered = board.kind == capture::BoardKind::asymmetric_circles;
  std::size_t dark = 0;
  std::size_t light = 0;
  Image<float> picture = grey;
  DotSearch search = search_dots(picture, board, dark);
  if (search.grid.empty()) {
    picture = negative(grey);
    DotSearch inverse = search_dots(picture, board, light);
    if (!inverse.grid.empty() || !search.other) search = std::move(inverse);
  }
  if (search.grid.empty()) {
    const std::string wanted = named({board.columns, board.rows, corners.staggered});
    if (search.other) {
      throw InputError(name + ": no " + wanted + " found, but a" +
                       (search.other->staggered ? "n " : " ") + named(*search.other) +
                       ": correct the board's kind, columns and rows");
    }
    throw InputError(name + ": no " + wanted + " found (" + std::to_string(dark) +
                     " dark dots in the picture, " + std::to_string(light) +
                     " light ones); take the picture again with the whole grid in view, sharp and "
                     "evenly lit, or correct the board's kind, columns and rows");
  }
  corners.pixels = std::move(search.grid);
  refine(picture, corners.pixels);
  const std::vector<double> nearest = nearest_distances(corners.pixels);
  std::vector<double> blurs;
  for (std::size_t k = 0; k < corners.pixels.size(); ++k) {
    const Vector2d& dot = corners.pixels[k];
    blurs.push_back(profile_blur(picture, dot, dot + Vector2d(0.5 * nearest[k], 0.0)));
  }
  corners.blur_px = upper_median(std::move(blurs));
  return corners;
}

}  // namespace kappamu::calib
