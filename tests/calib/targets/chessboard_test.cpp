#include "calib/targets/chessboard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "calib/targets/corner_fit.h"
#include "tests/calib/board_scene.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using ::testing::HasSubstr;
using testing::photograph;
using testing::tilted;

constexpr int columns = 9;
constexpr int rows = 6;
constexpr double square_mm = 4.0;

Lens camera_lens() {
  return {480, 360, 620.0, 625.0, 236.0, 184.0, {-0.15, 0.05, 0.001, -0.0005, 0.0}};
}

Eigen::Vector3d middle() {
  return {0.5 * square_mm * (columns - 1), 0.5 * square_mm * (rows - 1), 0.0};
}

// Measured RMS 0.022 px, times four; the scatter of the picture's 16 jittered rays per pixel is
// most of it (CornerFit.* draws finer ones).
constexpr double corner_tolerance_px = 0.088;

TEST(Chessboard, FindsTheCornersThatWereDrawn) {
  std::mt19937 random(1);
  const Lens lens = camera_lens();
  const Rigid pose = tilted(0.3, -0.25, 0.1, {2.0, -1.0, 80.0}, middle());
  const Image<float> image = photograph(lens, pose, columns, rows, square_mm, 0.01, random);
  const BoardCorners corners = find_chessboard(image, columns, rows, "drawn");
  ASSERT_EQ(corners.pixels.size(), std::size_t{columns * rows});
  double sum = 0.0;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Eigen::Vector2d truth =
          lens.project(pose * Eigen::Vector3d(square_mm * i, square_mm * j, 0.0));
      EXPECT_LT((corners.at(i, j) - truth).norm(), corner_tolerance_px) << i << " " << j;
      sum += (corners.at(i, j) - truth).squaredNorm();
    }
  }
  RecordProperty("corner_rms_px", std::to_string(std::sqrt(sum / (columns * rows))));
}

// Larger than what detectors are given: they see it reduced, by a factor that is not whole.
TEST(Chessboard, CornersOfALargePictureLieWhereTheyWereDrawn) {
  const Lens lens{1900, 1400, 2900.0, 2905.0, 955.0, 690.0, {}};
  std::mt19937 random(11);
  const Rigid pose = testing::tilted(0.3, -0.2, 0.1, {2.0, -3.0, 300.0}, {40.0, 25.0, 0.0});
  const Image<float> image =
      testing::blurred(testing::photograph(lens, pose, 9, 6, 10.0, 0.01, random), 2.0);
  const BoardCorners corners = find_chessboard(image, 9, 6, "large");
  // As the whole picture alone says, begun at the truth.
  BoardCorners whole{9, 6, {}};
  for (int k = 0; k < 54; ++k) {
    whole.pixels.push_back(
        lens.project(pose * Eigen::Vector3d(10.0 * (k % 9), 10.0 * (k / 9), 0.0)));
  }
  refine_corners(image, whole);
  for (std::size_t k = 0; k < whole.pixels.size(); ++k) {
    EXPECT_LT((corners.pixels[k] - whole.pixels[k]).norm(), 0.02) << k;
  }
  double largest = 0.0;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 9; ++i) {
      const Eigen::Vector2d truth = lens.project(pose * Eigen::Vector3d(10.0 * i, 10.0 * j, 0.0));
      largest = std::max(largest, (corners.at(i, j) - truth).norm());
    }
  }
  EXPECT_LT(largest, 0.08);
}

// Inner corners count; 10 x 7 squares are the usual mistake.
TEST(Chessboard, BoardOfAnotherSizeIsTold) {
  const Lens lens{640, 480, 1000.0, 1000.0, 320.0, 240.0, {}};
  std::mt19937 random(12);
  const Rigid pose = testing::tilted(0.3, -0.2, 0.1, {2.0, -3.0, 300.0}, {40.0, 25.0, 0.0});
  const Image<float> image = testing::photograph(lens, pose, 9, 6, 10.0, 0.01, random);
  using Size = std::array<int, 2>;
  for (const auto& [wide, high] : {Size{10, 7}, Size{7, 10}, Size{9, 7}, Size{11, 8}}) {
    auto other = other_chessboard(image, wide, high);
    ASSERT_TRUE(other) << wide << " x " << high;
    std::sort(other->begin(), other->end());
    EXPECT_EQ(*other, (Size{6, 9})) << wide << " x " << high;
  }
  // Found as a part, it is told from the whole.
  const auto whole = other_chessboard(image, 8, 5, Sizes::larger);
  ASSERT_TRUE(whole);
  EXPECT_EQ((*whole)[0] * (*whole)[1], 54);
  EXPECT_FALSE(other_chessboard(image, 9, 6, Sizes::larger));
  EXPECT_FALSE(other_chessboard(image, 6, 9, Sizes::larger));
  EXPECT_FALSE(other_chessboard(Image<float>(640, 480, 1), 9, 6));
}

TEST(Chessboard, BrightnessScaleDoesNotMatter) {
  std::mt19937 random(2);
  const Rigid pose = tilted(-0.2, 0.2, 0.0, {0.0, 0.0, 80.0}, middle());
  Image<float> image = photograph(camera_lens(), pose, columns, rows, square_mm, 0.0, random);
  const BoardCorners bright = find_chessboard(image, columns, rows, "bright");
  for (float& value : image.values()) value *= 1.0F / 64.0F;
  const BoardCorners dark = find_chessboard(image, columns, rows, "dark");
  for (std::size_t k = 0; k < bright.pixels.size(); ++k) {
    EXPECT_LT((bright.pixels[k] - dark.pixels[k]).norm(), 1e-3);  // single precision inside OpenCV
  }
}

TEST(Chessboard, OrderIsUprightWhateverTheDetectorGave) {
  for (const auto& [wide, tall] : {std::pair{9, 6}, std::pair{6, 9}, std::pair{5, 5}}) {
    BoardCorners truth{wide, tall, {}};
    for (int j = 0; j < tall; ++j) {
      for (int i = 0; i < wide; ++i) {
        truth.pixels.emplace_back(100.0 + 20.0 * i + 3.0 * j, 80.0 - 4.0 * i + 21.0 * j);
      }
    }
    BoardCorners turned = truth;
    std::reverse(turned.pixels.begin(), turned.pixels.end());
    make_upright(turned);
    EXPECT_EQ(turned.pixels, truth.pixels);
    BoardCorners mirrored = truth;
    for (int j = 0; j < tall; ++j) {
      std::reverse(mirrored.pixels.begin() + j * wide, mirrored.pixels.begin() + (j + 1) * wide);
    }
    make_upright(mirrored);
    EXPECT_EQ(mirrored.pixels, truth.pixels);
  }
}

TEST(Chessboard, SquareBoardTurnedByAQuarterIsTurnedBack) {
  constexpr int n = 5;
  BoardCorners truth{n, n, {}};
  BoardCorners turned{n, n, {}};
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      truth.pixels.emplace_back(20.0 * i, 20.0 * j);
      turned.pixels.emplace_back(20.0 * (n - 1 - j), 20.0 * i);
    }
  }
  make_upright(turned);
  EXPECT_EQ(turned.pixels, truth.pixels);
}

TEST(Chessboard, MissingBoardIsOneSentenceNamingFileAndFix) {
  const Image<float> blank(200, 160, 1, 0.5F);
  const std::string sentence =
      sentence_of([&] { find_chessboard(blank, columns, rows, "calibration/board_03.png"); });
  EXPECT_THAT(sentence, HasSubstr("calibration/board_03.png"));
  EXPECT_THAT(sentence, HasSubstr("no chessboard of 9 x 6 inner corners found"));
  EXPECT_THAT(sentence, HasSubstr("take the picture again"));
}

}  // namespace
}  // namespace kappamu::calib
