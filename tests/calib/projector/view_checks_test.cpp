// Board photographs and planes that cannot do: each is told by name, at the edge that
// docs/limits.md states. The edges are printed where they are measured.
#include "calib/projector/view_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "calib/targets/chessboard.h"
#include "core/error.h"
#include "tests/calib/board_scene.h"
#include "tests/calib/projector/projector_scene.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using testing::tilted;

constexpr int columns = 9;
constexpr int rows = 6;
constexpr double square_mm = 4.0;
constexpr double noise_px = 0.03;

Lens camera_lens() {
  return {640, 480, 820.0, 823.0, 322.0, 236.0, {-0.12, 0.08, 0.0015, -0.001}};
}

Eigen::Vector3d middle() {
  return {0.5 * square_mm * (columns - 1), 0.5 * square_mm * (rows - 1), 0.0};
}

/// Ten views about the frame's middle, their normals up to `tilt` radians off the axis; `reach`
/// scales how far from the middle (or, with `corner`, from the upper left) they go.
std::vector<BoardView> views_with(double tilt, double reach, bool corner, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<BoardView> views;
  for (int v = 0; v < 10; ++v) {
    const double around = 0.628 * v;
    const double depth = (corner ? 110.0 : 75.0) * (1.0 + 0.15 * unit(random));
    Eigen::Vector3d centre(reach * 0.13 * depth * unit(random), reach * 0.1 * depth * unit(random),
                           depth);
    if (corner) centre += Eigen::Vector3d(-0.18, -0.12, 0.0) * depth;
    const Rigid pose = tilted(tilt * std::cos(around), tilt * std::sin(around), 0.2 * unit(random),
                              centre, middle());
    views.push_back(testing::seen(camera_lens(), pose, columns, rows, square_mm, noise_px, random));
    views.back().name = "board_" + std::to_string(v) + ".png";
  }
  return views;
}

CameraCalibration calibrated(const std::vector<BoardView>& views) {
  return calibrate_camera(views, square_mm, 640, 480);
}

TEST(ViewChecks, GoodViewsPassWithoutAWord) {
  const auto views = views_with(0.5, 1.0, false, 1);
  EXPECT_THAT(check_camera_views(views, calibrated(views)), IsEmpty());
}

// The edge: docs/limits.md has what this prints.
TEST(ViewChecks, ParallelBoardsAreRefused) {
  std::printf("normals off the axis [degrees], focal length known to [%%], off by [%%]\n");
  for (const double degrees : {0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 30.0}) {
    const auto views = views_with(degrees / 57.2958, 1.0, false, 2);
    std::string refusal;
    try {
      const CameraCalibration found = calibrated(views);
      std::printf("%5.1f  %8.3f  %8.3f\n", degrees,
                  100.0 * found.standard_deviation(0) / found.lens.fx,
                  100.0 * std::abs(found.lens.fx / camera_lens().fx - 1.0));
      const auto sentences = check_camera_views(views, found);
      if (degrees >= 30.0) {
        EXPECT_THAT(sentences, IsEmpty());
      }
    } catch (const InputError& error) {
      refusal = error.what();
      std::printf("%5.1f  %s\n", degrees, error.what());
      EXPECT_THAT(refusal, HasSubstr("tilted by 20 to 40 degrees"));
      EXPECT_LT(degrees, 30.0);
    }
    if (degrees <= 0.5) {
      EXPECT_NE(refusal, "");
    }
  }
}

TEST(ViewChecks, ParallelBoardsAreToldByName) {
  const auto views = views_with(0.03, 1.0, false, 2);
  CameraCalibration calibration;
  calibration.lens = camera_lens();
  calibration.views.resize(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    calibration.camera_from_board.push_back(
        tilted(0.01 * static_cast<double>(v), 0.0, 0.0, {0.0, 0.0, 80.0}, middle()));
  }
  calibration.covariance(0, 0) = std::pow(0.03 * calibration.lens.fx, 2);
  const auto sentences = check_camera_views(views, calibration);
  ASSERT_FALSE(sentences.empty());
  EXPECT_THAT(sentences[0], HasSubstr("all 10 views lie within 5.2 degrees of parallel"));
  EXPECT_THAT(sentences[0], HasSubstr("known to 3.0 % only"));
  EXPECT_THAT(sentences[0], HasSubstr(".png first"));
  calibration.covariance(0, 0) = std::pow(0.3 * calibration.lens.fx, 2);
  EXPECT_THAT(sentence_of([&] { check_camera_views(views, calibration); }),
              HasSubstr("known to 30.0 % only"));
}

TEST(ViewChecks, BoardsInOneCornerAreTold) {
  const auto views = views_with(0.5, 0.3, true, 3);
  const CameraCalibration found = calibrated(views);
  const auto sentences = check_camera_views(views, found);
  ASSERT_THAT(sentences, SizeIs(1));
  EXPECT_THAT(sentences[0], HasSubstr("the right"));
  EXPECT_THAT(sentences[0], HasSubstr("the bottom"));
  EXPECT_THAT(sentences[0], HasSubstr("board_"));
}

TEST(ViewChecks, BlurredBoardIsNamed) {
  std::mt19937 random(4);
  const Lens lens{480, 360, 620.0, 625.0, 236.0, 184.0, {-0.15, 0.05, 0.001, -0.0005}};
  const Rigid pose = tilted(0.3, -0.25, 0.1, {2.0, -1.0, 80.0}, middle());
  const Image<float> sharp = testing::photograph(lens, pose, columns, rows, square_mm, 0.0, random);
  std::vector<BoardView> views(5);
  std::printf("blur [px], measured [px], corner RMS error [px]\n");
  for (const double blur : {0.0, 1.0, 2.0, 3.0, 4.0, 6.0}) {
    Image<float> image = testing::blurred(sharp, blur);
    std::normal_distribution<float> grain(0.0F, 0.01F);
    for (float& value : image.values()) value += grain(random);
    BoardCorners corners;
    try {
      corners = find_chessboard(image, columns, rows, "blurred.png");
    } catch (const InputError& error) {
      std::printf("%.0f  not found\n", blur);
      EXPECT_THAT(error.what(), HasSubstr("blurred.png: no chessboard"));
      EXPECT_GE(blur, 6.0);
      continue;
    }
    double sum = 0.0;
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        const Eigen::Vector3d corner(square_mm * i, square_mm * j, 0.0);
        sum += (corners.at(i, j) - lens.project(pose * corner)).squaredNorm();
      }
    }
    std::printf("%.0f  %.2f  %.3f\n", blur, corners.blur_px, std::sqrt(sum / (columns * rows)));
    if (blur <= 3.0) {
      // A pixel's own width is 0.29 px of deviation; noise and the corners nearby add some.
      EXPECT_NEAR(corners.blur_px, std::hypot(blur, 0.29), 0.15 * blur + 0.3);
    }
    if (blur == 0.0) {
      for (BoardView& view : views) view = {"sharp.png", corners};
    } else if (blur == 3.0) {
      views[2] = {"blurred.png", corners};
    }
  }
  CameraCalibration calibration;
  calibration.lens = lens;
  calibration.camera_from_board.assign(5, pose);
  calibration.views.resize(5);
  calibration.covariance(0, 0) = 1.0;
  const auto sentences = check_camera_views(views, calibration);
  const auto named = std::find_if(sentences.begin(), sentences.end(), [](const std::string& s) {
    return s.find("blurred.png: the board's edges are blurred") == 0;
  });
  EXPECT_NE(named, sentences.end());
  for (const std::string& sentence : sentences)
    EXPECT_EQ(sentence.find("sharp.png: "), sentence.npos);
}

TEST(ViewChecks, OnePlaneThatMovedOrIsTurnedIsNamed) {
  const testing::ProjectorScene rig;
  auto planes = rig.planes(6, noise_px, 6);
  for (std::size_t p = 0; p < planes.size(); ++p) {
    planes[p].name = "plane_" + std::to_string(p) + ".png";
    planes[p].projected.first_square_dark = true;
  }
  EXPECT_THAT(check_planes(planes), IsEmpty());
  auto turned = planes;
  std::reverse(turned[3].projected.pixels.begin(), turned[3].projected.pixels.end());
  turned[3].projected.first_square_dark = false;
  const auto refused = [&rig](const std::vector<PlaneView>& views) {
    return sentence_of(
        [&] { calibrate_projector(rig.camera, rig.printed, rig.projected, views, 1024, 768); });
  };
  EXPECT_THAT(refused(turned), HasSubstr("plane_3.png: this plane does not agree"));
  ASSERT_THAT(check_planes(turned), SizeIs(1));
  EXPECT_THAT(check_planes(turned)[0], HasSubstr("plane_3.png: the projected board is turned"));
  // 2 mm between the two pictures, at 160 mm.
  auto moved = planes;
  for (Eigen::Vector2d& pixel : moved[1].projected.pixels) pixel.x() += 20.0;
  EXPECT_THAT(refused(moved), HasSubstr("plane_1.png: this plane does not agree"));
}

TEST(ViewChecks, WrongSquareSizeShowsInThePlanesDistance) {
  std::vector<Rigid> planes(3);
  for (int p = 0; p < 3; ++p) planes[p].translation = {0.0, 0.0, 100.0 + 5.0 * p};
  Rigid sample;
  sample.translation = {0.0, 0.0, 100.0};
  EXPECT_THAT(check_scale(planes, sample, 4.0), IsEmpty());
  for (Rigid& plane : planes) plane.translation *= 1.3;
  ASSERT_THAT(check_scale(planes, sample, 5.2), SizeIs(1));
  EXPECT_THAT(check_scale(planes, sample, 5.2)[0], HasSubstr("board.square_mm (5.2)"));
}

}  // namespace
}  // namespace kappamu::calib
