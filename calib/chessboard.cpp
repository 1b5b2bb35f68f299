#include "calib/chessboard.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace kappamu::calib {
namespace {

/// Mean step along a row and along a column, in pixels.
Eigen::Vector2d mean_step(const BoardCorners& corners, bool along_row) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  if (along_row) {
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

double smallest_spacing(const BoardCorners& corners) {
  double smallest = 1e30;
  for (int j = 0; j < corners.rows; ++j) {
    for (int i = 0; i < corners.columns; ++i) {
      const Eigen::Vector2d& here = corners.at(i, j);
      if (i + 1 < corners.columns) {
        smallest = std::min(smallest, (corners.at(i + 1, j) - here).norm());
      }
      if (j + 1 < corners.rows) {
        smallest = std::min(smallest, (corners.at(i, j + 1) - here).norm());
      }
    }
  }
  return smallest;
}

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

/// Coarse corners, by OpenCV's detectors in the order of their cost: the adaptive one, the
/// sector-based one, the adaptive one at twice the size for boards of small squares, and at last
/// with equalised histogram, which helps under uneven light and takes seconds on a noisy dark
/// ground.
bool detect(const cv::Mat& bytes, const cv::Size& size, std::vector<cv::Point2f>& points) {
  constexpr int adaptive = cv::CALIB_CB_ADAPTIVE_THRESH;
  if (cv::findChessboardCorners(bytes, size, points, adaptive)) return true;
  if (cv::findChessboardCornersSB(bytes, size, points)) return true;
  constexpr double factor = 2.0;
  cv::Mat large;
  cv::resize(bytes, large, cv::Size(), factor, factor, cv::INTER_CUBIC);
  if (!cv::findChessboardCorners(large, size, points, adaptive)) {
    cv::Mat smooth;
    cv::GaussianBlur(bytes, smooth, cv::Size(), 1.0);
    return cv::findChessboardCorners(smooth, size, points, adaptive | cv::CALIB_CB_NORMALIZE_IMAGE);
  }
  for (cv::Point2f& point : points) {
    // Pixel centres are at integers in both pictures.
    point.x = static_cast<float>((point.x + 0.5) / factor - 0.5);
    point.y = static_cast<float>((point.y + 0.5) / factor - 0.5);
  }
  return true;
}

}  // namespace

void make_upright(BoardCorners& corners) {
  const Eigen::Vector2d along_row = mean_step(corners, true);
  const Eigen::Vector2d along_column = mean_step(corners, false);
  // With y down, turning right to down is a positive cross product.
  if (along_row.x() * along_column.y() - along_row.y() * along_column.x() < 0.0) {
    mirror_rows(corners);
  }
  if (corners.columns == corners.rows) {
    // Steps turn by 90° each time: one of the four has its direction within 45° of right.
    for (int turn = 0; turn < 3; ++turn) {
      const Eigen::Vector2d step = mean_step(corners, true);
      if (step.x() >= std::abs(step.y())) break;
      turn_quarter(corners);
    }
  } else if (mean_step(corners, true).x() < 0.0) {
    std::reverse(corners.pixels.begin(), corners.pixels.end());
  }
}

Image<float> to_grey(const Image<float>& image) {
  if (image.channels() != 3) return image;
  Image<float> grey(image.width(), image.height(), 1);
  for (std::size_t i = 0; i < grey.size(); ++i) {
    const float* rgb = &image.values()[3 * i];
    grey.values()[i] = 0.299F * rgb[0] + 0.587F * rgb[1] + 0.114F * rgb[2];
  }
  return grey;
}

BoardCorners find_chessboard(const Image<float>& grey, int columns, int rows,
                             const std::string& name, const CornerRefinement& refinement) {
  check(grey.channels() == 1, "find_chessboard wants a grey image");
  std::vector<cv::Point2f> points;
  const bool found = detect(stretch_to_bytes(grey), cv::Size(columns, rows), points);
  if (!found) {
    throw InputError(
        name + ": no chessboard of " + std::to_string(columns) + " x " + std::to_string(rows) +
        " inner corners found; take the picture again with the whole board in view, "
        "sharp and evenly lit, or correct the board's columns and rows in session.json");
  }
  BoardCorners corners{columns, rows, {}};
  const auto keep = [&corners, &points] {
    corners.pixels.clear();
    for (const cv::Point2f& point : points) corners.pixels.emplace_back(point.x, point.y);
  };
  keep();
  // Less than half a square, so that the window never sees a neighbouring corner.
  const int half =
      std::clamp(static_cast<int>(0.4 * smallest_spacing(corners)), 2, refinement.half_window_px);
  const cv::Mat sharp(grey.height(), grey.width(), CV_32F,
                      const_cast<float*>(grey.values().data()));  // OpenCV's view; only read
  cv::Mat smooth;  // its own memory: the blur must not write into the caller's image
  const double smoothing = std::min(refinement.smoothing_px, half / 3.0);
  if (smoothing > 0.0) cv::GaussianBlur(sharp, smooth, cv::Size(), smoothing);
  const cv::TermCriteria stop(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 100, 1e-4);
  cv::cornerSubPix(smooth.empty() ? sharp : smooth, points, cv::Size(half, half), cv::Size(-1, -1),
                   stop);
  keep();
  make_upright(corners);
  return corners;
}

}  // namespace kappamu::calib
