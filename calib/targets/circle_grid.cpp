#include "calib/targets/circle_grid.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

#include "calib/targets/board_picture.h"
#include "calib/targets/board_shape.h"
#include "calib/targets/chessboard.h"
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

/// Sense of the lattice in the picture: positive where rows turn clockwise into columns.
double handedness(const BoardCorners& corners) {
  const Vector2d along = corners.at(corners.columns - 1, 0) - corners.at(0, 0);
  const Vector2d down = corners.at(0, corners.rows - 1) - corners.at(0, 0);
  return along.x() * down.y() - along.y() * down.x();
}

/// A staggered grid with an odd number of rows is its own mirror image, top to bottom.
void unmirror_staggered(BoardCorners& corners) {
  if (handedness(corners) >= 0.0) return;
  std::vector<Vector2d> rows;
  for (int j = corners.rows - 1; j >= 0; --j) {
    for (int i = 0; i < corners.columns; ++i) rows.push_back(corners.at(i, j));
  }
  corners.pixels = rows;
}

}  // namespace

BoardCorners find_circles(const Image<float>& grey, const capture::Board& board,
                          const std::string& name) {
  check(grey.channels() == 1, "find_circles wants a grey image");
  const bool staggered = board.kind == capture::BoardKind::asymmetric_circles;
  const int kind = staggered ? cv::CALIB_CB_ASYMMETRIC_GRID : cv::CALIB_CB_SYMMETRIC_GRID;
  const cv::Mat bytes = stretch_to_bytes(grey);
  const cv::Size size(board.columns, board.rows);
  const cv::Ptr<cv::FeatureDetector> dots = dot_detector(bytes, board);
  std::vector<cv::Point2f> points;
  bool found = cv::findCirclesGrid(bytes, size, points, kind, dots);
  if (!found) {
    found = cv::findCirclesGrid(bytes, size, points, kind | cv::CALIB_CB_CLUSTERING, dots);
  }
  if (!found) {
    std::vector<cv::KeyPoint> seen;
    dots->detect(bytes, seen);
    throw InputError(name + ": no " + (staggered ? "asymmetric " : "") + "circle grid of " +
                     std::to_string(board.columns) + " x " + std::to_string(board.rows) +
                     " dots found (" + std::to_string(seen.size()) +
                     " dark dots in the picture); take the picture again with the whole grid in "
                     "view, sharp and evenly lit, or correct the board's kind, columns and rows in "
                     "session.json");
  }
  BoardCorners corners{board.columns, board.rows, {}};
  corners.staggered = staggered;
  for (const cv::Point2f& point : points) corners.pixels.emplace_back(point.x, point.y);
  refine(grey, corners.pixels);
  if (staggered) {
    unmirror_staggered(corners);
  } else {
    make_upright(corners);
  }
  const std::vector<double> nearest = nearest_distances(corners.pixels);
  std::vector<double> blurs;
  for (std::size_t k = 0; k < corners.pixels.size(); ++k) {
    const Vector2d& dot = corners.pixels[k];
    blurs.push_back(profile_blur(grey, dot, dot + Vector2d(0.5 * nearest[k], 0.0)));
  }
  corners.blur_px = upper_median(std::move(blurs));
  return corners;
}

}  // namespace kappamu::calib
