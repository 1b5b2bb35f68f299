#include "calib/targets/chessboard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
