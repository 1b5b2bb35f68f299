// Corners of rendered boards against where they were drawn, beside OpenCV's refinement.
#include "calib/targets/corner_fit.h"

#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>

#include "calib/targets/board_shape.h"
#include "calib/targets/chessboard.h"
#include "data_synthetic/rig/render.h"
#include "data_synthetic/rig/targets.h"
#include "tests/calib/board_scene.h"

namespace kappamu::calib {
namespace {

const capture::Board board{9, 6, 2.0};

Lens camera_lens() {
  return {400, 300, 1190.0, 1191.0, 203.0, 147.0, {-0.3, 0.8, 0.0008, -0.0006, 0.0}};
}

/// Boards tilted about both axes, turned by `turns`; one of them along the pixels' rows.
std::vector<Rigid> poses() {
  std::vector<Rigid> result;
  for (const double turn : {0.0, 0.04, 0.3}) {
    result.push_back(
        testing::tilted(0.4 * turn, -0.8 * turn, turn, {0.4, -0.3, 95.0}, {8.0, 5.0, 0.0}));
  }
  return result;
}

/// Linear in light, paper at 1.
Image<float> picture_of(const Rigid& pose, double noise) {
  static const Lens lens = camera_lens();
  static const synthetic::RayTable rays(lens, 4);
  synthetic::Illumination light;
  light.ambient = std::numbers::pi / 0.9;
  Image<float> image =
      to_grey(synthetic::render_quads(rays, Rigid{}, {synthetic::board_quad(board, pose)}, light));
  std::mt19937 random(5);
  std::normal_distribution<float> grain(0.0F, static_cast<float>(noise));
  for (float& value : image.values()) value += grain(random);
  return image;
}

Eigen::Vector2d drawn(const Rigid& pose, int i, int j) {
  return camera_lens().project(pose * Eigen::Vector3d(board.square_mm * i, board.square_mm * j, 0));
}

/// Root mean square over the boards' corners, per coordinate [px].
struct Miss {
  double ours = 0.0;
  double opencv = 0.0;
};
template <class Change>
Miss miss(const Change& change) {
  Miss sum;
  double count = 0.0;
  for (const Rigid& pose : poses()) {
    Image<float> image = picture_of(pose, 0.008);
    change(image);
    const BoardCorners found = find_chessboard(image, board.columns, board.rows, "drawn");
    std::vector<cv::Point2f> points;
    for (const Eigen::Vector2d& p : found.pixels) {
      points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
    }
    const cv::Mat view(image.height(), image.width(), CV_32F, image.values().data());
    cv::cornerSubPix(view, points, cv::Size(5, 5), cv::Size(-1, -1),
                     cv::TermCriteria(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 100, 1e-4));
    for (int k = 0; k < board.columns * board.rows; ++k) {
      const Eigen::Vector2d truth = drawn(pose, k % board.columns, k / board.columns);
      sum.ours += (found.pixels[k] - truth).squaredNorm();
      sum.opencv += (Eigen::Vector2d(points[k].x, points[k].y) - truth).squaredNorm();
      count += 2.0;
    }
  }
  return {std::sqrt(sum.ours / count), std::sqrt(sum.opencv / count)};
}

TEST(CornerFit, LiesWhereTheCornerWasDrawnInLightAndInCodes) {
  const auto shade = [](Image<float>& image) {
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) image(x, y) *= 1.0F - 0.002F * static_cast<float>(x);
    }
  };
  const auto respond = [](Image<float>& image) {
    for (float& value : image.values()) value = std::pow(std::max(value, 0.0F), 1.0F / 2.2F);
  };
  const auto show = [](const char* name, const Miss& found) {
    std::printf("%s: RMS per coordinate %.4f px, cornerSubPix %.4f px\n", name, found.ours,
                found.opencv);
    return found;
  };
  const Miss linear = show("linear in light", miss([](Image<float>&) {}));
  const Miss shaded = show("shaded from 1 to 0.2", miss(shade));
  const Miss coded = show("response of exponent 1/2.2", miss(respond));
  const Miss blurred = show(
      "blurred by 1 px", miss([](Image<float>& image) { image = testing::blurred(image, 1.0); }));
  EXPECT_LT(linear.ours, 0.0025);
  EXPECT_LT(linear.ours, 0.2 * linear.opencv);
  EXPECT_LT(shaded.ours, 0.005);
  EXPECT_LT(coded.ours, 0.5 * coded.opencv);
  EXPECT_LT(blurred.ours, 0.5 * blurred.opencv);
}

TEST(CornerFit, IsReachedFromAPixelAndAHalfAway) {
  const Rigid pose = poses()[2];
  const Image<float> image = picture_of(pose, 0.008);
  const Eigen::Vector2d truth = drawn(pose, 4, 3);
  CornerWindow window;
  window.steps << drawn(pose, 5, 3) - truth, drawn(pose, 4, 4) - truth;
  for (int k = 0; k < 8; ++k) {
    const double angle = 0.785 * k;
    const auto found =
        fit_corner(image, truth + 1.5 * Eigen::Vector2d(std::cos(angle), std::sin(angle)), window);
    ASSERT_TRUE(found.has_value()) << k;
    EXPECT_LT((*found - truth).norm(), 0.01) << k;
  }
}

// A board whose border squares are cut to a third: their outer edges lie in the windows of the
// outer corners and pull what looks at gradients.
TEST(CornerFit, NarrowBorderSquaresDoNotPullTheOuterCorners) {
  const Rigid pose = poses()[2];
  Image<float> image = picture_of(pose, 0.008);
  const auto place = [&](double i, double j) {
    const Eigen::Vector2d at = camera_lens().project(
        pose * Eigen::Vector3d(board.square_mm * i, board.square_mm * j, 0.0));
    return cv::Point(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
  };
  constexpr double left = 0.3;  // of a square
  const double right = board.columns - 1 + left;
  const double bottom = board.rows - 1 + left;
  std::vector<cv::Point> outline;
  for (int k = 0; k < 10; ++k) outline.push_back(place(-left + 0.1 * k * (right + left), -left));
  for (int k = 0; k < 10; ++k) outline.push_back(place(right, -left + 0.1 * k * (bottom + left)));
  for (int k = 0; k < 10; ++k) outline.push_back(place(right - 0.1 * k * (right + left), bottom));
  for (int k = 0; k < 10; ++k) outline.push_back(place(-left, bottom - 0.1 * k * (bottom + left)));
  cv::Mat inside = cv::Mat::zeros(image.height(), image.width(), CV_8U);
  cv::fillPoly(inside, std::vector<std::vector<cv::Point>>{outline}, cv::Scalar(255));
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (inside.at<uchar>(y, x) == 0) image(x, y) = 1.0F;
    }
  }
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-1.0, 1.0);
  BoardCorners corners{board.columns, board.rows, {}};
  for (int k = 0; k < board.columns * board.rows; ++k) {
    corners.pixels.push_back(drawn(pose, k % board.columns, k / board.columns) +
                             Eigen::Vector2d(off(random), off(random)));
  }
  refine_corners(image, corners);
  double worst = 0.0;
  for (int k = 0; k < board.columns * board.rows; ++k) {
    worst = std::max(
        worst, (corners.pixels[k] - drawn(pose, k % board.columns, k / board.columns)).norm());
  }
  std::printf("border squares cut to %.1f: worst corner %.3f px\n", left, worst);
  EXPECT_LT(worst, 0.05);
}

TEST(CornerFit, WhatIsNoCornerIsNotTaken) {
  std::mt19937 random(2);
  std::normal_distribution<float> grain(0.0F, 0.01F);
  Image<float> even(40, 40, 1, 0.5F);
  Image<float> edge(40, 40, 1);
  for (int k = 0; k < 40 * 40; ++k) {
    even.values()[k] += grain(random);
    edge.values()[k] = (k % 40 < 20 ? 0.1F : 0.9F) + grain(random);
  }
  CornerWindow window;
  window.steps << 12.0, 1.0, -1.0, 12.0;
  EXPECT_FALSE(fit_corner(even, {20.0, 20.0}, window).has_value());
  EXPECT_FALSE(fit_corner(edge, {20.0, 20.0}, window).has_value());
  EXPECT_FALSE(fit_corner(Image<float>(40, 40, 1, 0.5F), {20.0, 20.0}, window).has_value());
}

}  // namespace
}  // namespace kappamu::calib
