#include "capture/radiance/chart_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/mcc.hpp>
#include <vector>

#include "capture/session/frames.h"
#include "capture/session/frames_at_once.h"
#include "core/parallel.h"

namespace kappamu::capture {
namespace {

constexpr int columns = 6;
constexpr int rows = 4;

/// The picture as people look at it: 8 bits, a display's gamma where the codes are linear, from its
/// darkest to its brightest thousandth.
cv::Mat displayed(const Image<std::uint16_t>& codes, Encoding encoding) {
  std::vector<std::uint16_t> sorted = codes.values();
  const std::size_t tail = sorted.size() / 1000;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(tail),
                   sorted.end());
  const double low = sorted[tail];
  std::nth_element(sorted.begin(), sorted.end() - 1 - static_cast<std::ptrdiff_t>(tail),
                   sorted.end());
  const double high = std::max<double>(sorted[sorted.size() - 1 - tail], low + 1.0);
  const double gamma = encoding == Encoding::linear ? 2.2 : 1.0;
  std::vector<uchar> shown(std::numeric_limits<std::uint16_t>::max() + std::size_t{1});
  for (std::size_t code = 0; code < shown.size(); ++code) {
    const double share = std::clamp((static_cast<double>(code) - low) / (high - low), 0.0, 1.0);
    shown[code] = cv::saturate_cast<uchar>(255.0 * std::pow(share, 1.0 / gamma));
  }
  cv::Mat picture(codes.height(), codes.width(), CV_8UC3);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      for (int c = 0; c < 3; ++c) picture.at<cv::Vec3b>(y, x)[2 - c] = shown[codes(x, y, c)];
    }
  }
  return picture;
}

/// The picture `factor` as large, each of its pixels the mean of those it covers.
Image<std::uint16_t> reduced(const Image<std::uint16_t>& codes, double factor) {
  const cv::Mat whole(codes.height(), codes.width(), CV_16UC3,
                      const_cast<std::uint16_t*>(codes.values().data()));
  cv::Mat small;
  cv::resize(whole, small, cv::Size(), factor, factor, cv::INTER_AREA);
  Image<std::uint16_t> image(small.cols, small.rows, 3);
  small.copyTo(cv::Mat(small.rows, small.cols, CV_16UC3, image.values().data()));
  return image;
}

/// From (column, row) of patch centres to pixels, by mcc's box; empty if it finds none.
cv::Mat lattice_by_mcc(const cv::Mat& picture) {
  try {
    const auto detector = cv::mcc::CCheckerDetector::create();
    if (!detector->process(picture, cv::mcc::MCC24)) return {};
    // Its box (CChartModel) is 16.75 x 11.25 with patches of 2.5, the first 0.25 from the rim, at a
    // pitch of 2.75.
    constexpr float left = -1.5F / 2.75F;
    constexpr float right = left + 16.75F / 2.75F;
    constexpr float bottom = left + 11.25F / 2.75F;
    const std::vector<cv::Point2f> box{
        {left, left}, {right, left}, {right, bottom}, {left, bottom}};
    return cv::getPerspectiveTransform(box, detector->getBestColorChecker()->getBox());
  } catch (const cv::Exception&) {
    return {};
  }
}

cv::Point2d mapped(const cv::Mat& lattice, double column, double row) {
  const auto* h = lattice.ptr<double>();
  const double w = h[6] * column + h[7] * row + h[8];
  return {(h[0] * column + h[1] * row + h[2]) / w, (h[3] * column + h[4] * row + h[5]) / w};
}

/// Middle of the patch about `guess`: what is like its centre, if that has a patch's area.
std::optional<cv::Point2f> patch_middle(const cv::Mat& picture, const cv::Point2d& guess,
                                        double pitch_px, double cell_px2) {
  const int reach = static_cast<int>(std::lround(0.8 * pitch_px));
  const cv::Rect around =
      cv::Rect(cvRound(guess.x) - reach, cvRound(guess.y) - reach, 2 * reach + 1, 2 * reach + 1) &
      cv::Rect(0, 0, picture.cols, picture.rows);
  const cv::Point seed(cvRound(guess.x) - around.x, cvRound(guess.y) - around.y);
  if (!cv::Rect(0, 0, around.width, around.height).contains(seed)) return std::nullopt;
  cv::Mat region = picture(around).clone();
  cv::Mat mask = cv::Mat::zeros(around.height + 2, around.width + 2, CV_8U);
  const cv::Scalar tolerance = cv::Scalar::all(12.0);  // of 255, display codes
  cv::floodFill(region, mask, seed, cv::Scalar(), nullptr, tolerance, tolerance,
                4 | cv::FLOODFILL_FIXED_RANGE | cv::FLOODFILL_MASK_ONLY);
  const cv::Moments moments = cv::moments(mask, true);
  constexpr double patch_share = 0.7;  // of its cell: edges of 0.84 pitch
  if (moments.m00 < 0.6 * patch_share * cell_px2 || moments.m00 > 1.25 * patch_share * cell_px2) {
    return std::nullopt;
  }
  return cv::Point2f(static_cast<float>(moments.m10 / moments.m00 - 1.0 + around.x),
                     static_cast<float>(moments.m01 / moments.m00 - 1.0 + around.y));
}

/// Moves the lattice onto the patches' middles; gives how many it stands on.
int refine(const cv::Mat& picture, cv::Mat& lattice) {
  constexpr int rounds = 3;
  int seen = 0;
  for (int round = 0; round < rounds; ++round) {
    std::vector<cv::Point2f> from;
    std::vector<cv::Point2f> to;
    double pitch = 0.0;
    cv::Mat smooth;
    for (int p = 0; p < columns * rows; ++p) {
      const int column = p % columns;
      const int row = p / columns;
      const cv::Point2d right =
          mapped(lattice, column + 0.5, row) - mapped(lattice, column - 0.5, row);
      const cv::Point2d down =
          mapped(lattice, column, row + 0.5) - mapped(lattice, column, row - 0.5);
      pitch = std::sqrt(std::abs(right.cross(down)));
      if (!(pitch > 4.0) || pitch > picture.cols) return 0;
      if (smooth.empty())
        cv::GaussianBlur(picture, smooth, cv::Size(), std::max(0.5, pitch / 30.0));
      if (const auto middle =
              patch_middle(smooth, mapped(lattice, column, row), pitch, pitch * pitch)) {
        from.emplace_back(static_cast<float>(column), static_cast<float>(row));
        to.push_back(*middle);
      }
    }
    constexpr std::size_t fewest = 12;
    if (from.size() < fewest) return 0;
    std::vector<uchar> inliers;
    const cv::Mat better = cv::findHomography(from, to, cv::RANSAC, 0.1 * pitch, inliers);
    if (better.empty()) return 0;
    lattice = better;
    seen = static_cast<int>(std::count(inliers.begin(), inliers.end(), 1));
  }
  return seen;
}

bool neutrals_fall(const cv::Mat& picture, const cv::Mat& lattice) {
  int before = 256;
  for (int column = 0; column < columns; ++column) {
    const cv::Point2d at = mapped(lattice, column, rows - 1);
    const cv::Point pixel(cvRound(at.x), cvRound(at.y));
    if (!cv::Rect(0, 0, picture.cols, picture.rows).contains(pixel)) return false;
    const int green = picture.at<cv::Vec3b>(pixel)[1];
    if (green >= before && before < 255) return false;  // several may be saturated
    before = green;
  }
  return true;
}

}  // namespace

std::optional<ChartPlace> find_chart_place(const Image<std::uint16_t>& codes, Encoding encoding) {
  if (codes.channels() != 3) return std::nullopt;
  constexpr double searched_px = 1280.0;  // longest side; patches are far larger than its pixels
  const double factor = std::min(1.0, searched_px / std::max(codes.width(), codes.height()));
  cv::setRNGSeed(1);  // the detector draws: the same whatever its thread did before
  const cv::Mat picture =
      factor < 1.0 ? displayed(reduced(codes, factor), encoding) : displayed(codes, encoding);
  cv::Mat lattice = lattice_by_mcc(picture);
  if (lattice.empty()) return std::nullopt;
  ChartPlace place;
  place.patches = refine(picture, lattice);
  if (place.patches < columns * rows / 2 || !neutrals_fall(picture, lattice)) return std::nullopt;
  const std::array<std::array<int, 2>, 4> corners{
      {{0, 0}, {columns - 1, 0}, {columns - 1, rows - 1}, {0, rows - 1}}};
  for (std::size_t k = 0; k < 4; ++k) {
    const cv::Point2d at = mapped(lattice, corners[k][0], corners[k][1]);
    place.corners_px[k] = {(at.x + 0.5) / factor - 0.5, (at.y + 0.5) / factor - 0.5};
  }
  return place;
}

std::optional<ChartPlace> find_chart_place(const Session& session, const Stack& stack) {
  std::vector<std::optional<ChartPlace>> places(stack.size());
  const auto look = [&](int k) {
    const Frame& frame = stack[static_cast<std::size_t>(k)];
    // Float frames come out linear, whatever the session's encoding.
    const Encoding encoding =
        is_float_frame(session, frame) ? Encoding::linear : session.camera.encoding;
    places[static_cast<std::size_t>(k)] = find_chart_place(load_frame(session, frame), encoding);
  };
  for_rows(static_cast<int>(stack.size()), look, frames_at_once);
  std::optional<ChartPlace> best;
  for (const auto& place : places) {
    if (place && (!best || place->patches > best->patches)) best = place;
  }
  return best;
}

}  // namespace kappamu::capture
