#include "calib/targets/chessboard.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "calib/targets/board_picture.h"
#include "calib/targets/corner_fit.h"
#include "core/error.h"
#include "core/numbers/median.h"

namespace kappamu::calib {
namespace {

enum class Along { row, column };

/// Mean step along a row or a column, in pixels.
Eigen::Vector2d mean_step(const BoardCorners& corners, Along along) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  if (along == Along::row) {
    for (int j = 0; j < corners.rows; ++j) {
      sum += corners.at(corners.columns - 1, j) - corners.at(0, j);
    }
    return sum / (corners.rows * (corners.columns - 1));
  }
  for (int i = 0; i < corners.columns; ++i) {
    sum += corners.at(i, corners.rows - 1) - corners.at(i, 0);
  }
  return sum / (corners.columns * (corners.rows - 1));
}

void mirror_rows(BoardCorners& corners) {
  for (int j = 0; j < corners.rows; ++j) {
    const auto row = corners.pixels.begin() + static_cast<std::ptrdiff_t>(j) * corners.columns;
    std::reverse(row, row + corners.columns);
  }
}

/// The same square board with its order turned by 90°.
void turn_quarter(BoardCorners& corners) {
  const BoardCorners old = corners;
  for (int j = 0; j < old.rows; ++j) {
    for (int i = 0; i < old.columns; ++i) {
      corners.pixels[static_cast<std::size_t>(j) * old.columns + i] = old.at(j, old.rows - 1 - i);
    }
  }
}

/// Blur of the edge between two neighbouring corners, across its middle.
double edge_blur(const Image<float>& grey, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d middle = 0.5 * (a + b);
  const Eigen::Vector2d across = 0.45 * Eigen::Vector2d(b.y() - a.y(), a.x() - b.x());
  return profile_blur(grey, middle - across, middle + across);
}

double median_blur(const Image<float>& grey, const BoardCorners& corners) {
  std::vector<double> blurs;
  for (int j = 0; j < corners.rows; ++j) {
    for (int i = 0; i + 1 < corners.columns; ++i) {
      blurs.push_back(edge_blur(grey, corners.at(i, j), corners.at(i + 1, j)));
    }
  }
  return upper_median(std::move(blurs));
}

std::optional<bool> first_square_dark(const Image<float>& grey, const BoardCorners& corners) {
  if ((corners.columns + corners.rows) % 2 == 0) return std::nullopt;
  double difference = 0.0;  // of light squares over dark ones if the first is dark
  for (int j = 0; j + 1 < corners.rows; ++j) {
    for (int i = 0; i + 1 < corners.columns; ++i) {
      const Eigen::Vector2d middle = 0.25 * (corners.at(i, j) + corners.at(i + 1, j) +
                                             corners.at(i, j + 1) + corners.at(i + 1, j + 1));
      difference += ((i + j) % 2 == 0 ? -1.0 : 1.0) * bilinear(grey, middle);
    }
  }
  return difference > 0.0;
}

constexpr int adaptive = cv::CALIB_CB_ADAPTIVE_THRESH;
/// Pictures are searched at most so long: the adaptive detector takes half a minute on a noisy one
/// of eleven million pixels without the board.
constexpr int searched_px = 1280;

using Corners = std::vector<cv::Point2f>;
std::vector<Eigen::Vector2d> in_original(const ScaledPicture& picture, const Corners& points) {
  std::vector<Eigen::Vector2d> pixels;
  for (const cv::Point2f& point : points) pixels.push_back(picture.in_original(point));
  return pixels;
}

/// Coarse corners, by OpenCV's detectors in the order of their cost: the adaptive one, the
/// sector-based one, the adaptive one at twice the size for boards of small squares and with
/// equalised histogram, which helps under uneven light, and at last the sector-based one on the
/// whole picture. Empty where none finds the board.
std::vector<Eigen::Vector2d> detect(const Image<float>& grey, const cv::Size& size) {
  const double factor = reduction(view_of(grey), searched_px);
  Corners points;
  const ScaledPicture picture = scaled_bytes(grey, factor);
  if (cv::findChessboardCorners(picture.pixels, size, points, adaptive) ||
      cv::findChessboardCornersSB(picture.pixels, size, points)) {
    return in_original(picture, points);
  }
  const ScaledPicture large = scaled_bytes(grey, 2.0 * factor);
  if (cv::findChessboardCorners(large.pixels, size, points, adaptive)) {
    return in_original(large, points);
  }
  cv::Mat smooth;
  cv::GaussianBlur(picture.pixels, smooth, cv::Size(), 1.0);
  if (cv::findChessboardCorners(smooth, size, points, adaptive | cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return in_original(picture, points);
  }
  if (factor == 1.0) return {};
  const ScaledPicture whole(stretch_to_bytes(grey), 1.0);
  if (!cv::findChessboardCornersSB(whole.pixels, size, points)) return {};
  return in_original(whole, points);
}

}  // namespace

void make_upright(BoardCorners& corners) {
  const Eigen::Vector2d along_row = mean_step(corners, Along::row);
  const Eigen::Vector2d along_column = mean_step(corners, Along::column);
  // With y down, turning right to down is a positive cross product.
  if (along_row.x() * along_column.y() - along_row.y() * along_column.x() < 0.0) {
    mirror_rows(corners);
  }
  if (corners.columns == corners.rows) {
    // Steps turn by 90° each time: one of the four has its direction within 45° of right.
    for (int turn = 0; turn < 3; ++turn) {
      const Eigen::Vector2d step = mean_step(corners, Along::row);
      if (step.x() >= std::abs(step.y())) break;
      turn_quarter(corners);
    }
  } else if (mean_step(corners, Along::row).x() < 0.0) {
    std::reverse(corners.pixels.begin(), corners.pixels.end());
  }
}

Image<float> to_grey(const Image<float>& image) {
  if (image.channels() != 3) return image;
  Image<float> grey(image.width(), image.height(), 1);
  for (std::size_t i = 0; i < grey.size(); ++i) {
    grey.values()[i] = luminance_of(&image.values()[3 * i]);
  }
  return grey;
}

BoardCorners find_chessboard(const Image<float>& grey, int columns, int rows,
                             const std::string& name) {
  check(grey.channels() == 1, "find_chessboard wants a grey image");
  BoardCorners corners{columns, rows, detect(grey, cv::Size(columns, rows))};
  if (corners.pixels.empty()) {
    throw InputError(name + ": no chessboard of " + std::to_string(columns) + " x " +
                     std::to_string(rows) +
                     " inner corners found; take the picture again with the whole board in view, "
                     "sharp and evenly lit, or correct the board's columns and rows");
  }
  refine_corners_from(reduction(view_of(grey), searched_px), grey, corners);
  make_upright(corners);
  corners.blur_px = median_blur(grey, corners);
  corners.first_square_dark = first_square_dark(grey, corners);
  return corners;
}

std::optional<std::array<int, 2>> other_chessboard(const Image<float>& grey, int columns, int rows,
                                                   Sizes which) {
  const ScaledPicture picture = scaled_bytes(grey, reduction(view_of(grey), searched_px));
  constexpr int fewest = 3;
  std::vector<cv::Size> sizes;
  const int least = which == Sizes::all ? -1 : 0;
  for (int i = least; i <= 1; ++i) {
    for (int j = least; j <= 1; ++j) {
      if (columns + i >= fewest && rows + j >= fewest && (i != 0 || j != 0)) {
        sizes.emplace_back(columns + i, rows + j);
      }
    }
  }
  Corners points;
  cv::Mat seen;
  if (cv::findChessboardCornersSB(picture.pixels, cv::Size(fewest, fewest), points,
                                  cv::CALIB_CB_LARGER, seen) &&
      (which == Sizes::all || contains({seen.cols, seen.rows}, {columns, rows}))) {
    sizes.push_back(seen.size());
  }
  // The detector takes parts of a board for boards: the largest is the whole one.
  std::sort(sizes.begin(), sizes.end(), [](auto& a, auto& b) { return a.area() > b.area(); });
  for (const cv::Size& size : sizes) {
    if (cv::findChessboardCorners(picture.pixels, size, points, adaptive)) {
      return std::array<int, 2>{size.width, size.height};
    }
  }
  return std::nullopt;
}

bool contains(std::array<int, 2> board, std::array<int, 2> part) {
  std::sort(board.begin(), board.end());
  std::sort(part.begin(), part.end());
  return board[0] >= part[0] && board[1] >= part[1] && board != part;
}

BoardCorners find_projected_chessboard(const Image<float>& grey, int columns, int rows,
                                       const BoardCorners& printed, const std::string& name) {
  const BoardCorners found = find_chessboard(grey, columns, rows, name);
  std::vector<cv::Point2f> outline;
  cv::convexHull(image_points(printed.pixels), outline);
  // Half a spacing more: the corners themselves lie on the outline.
  const double reach = 0.5 * smallest_spacing(found);
  const bool is_printed = std::all_of(found.pixels.begin(), found.pixels.end(), [&](const auto& p) {
    const cv::Point2f point(static_cast<float>(p.x()), static_cast<float>(p.y()));
    return cv::pointPolygonTest(outline, point, true) > -reach;
  });
  if (!is_printed) return found;
  Image<float> without = grey;
  cv::Mat picture(without.height(), without.width(), CV_32F, without.values().data());
  // At a corner the grey is between black and white.
  const double between = bilinear(grey, found.pixels.front());
  cv::fillConvexPoly(picture, std::vector<cv::Point>(outline.begin(), outline.end()), between);
  return find_chessboard(without, columns, rows, name);
}

}  // namespace kappamu::calib
