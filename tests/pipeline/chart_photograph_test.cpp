// The chart in one photograph: patches where they are, codes as they are, in any quarter turn.
#include "pipeline/chart_photograph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "data_synthetic/rig/targets.h"
#include "io/image/image_file.h"
#include "tests/app/process.h"

namespace kappamu::pipeline {
namespace {

constexpr int pitch = 40;
constexpr double gamma_exponent = 0.45;

int code_of(double reflectance) {
  return static_cast<int>(std::lround(255.0 * std::pow(0.95 * reflectance, gamma_exponent)));
}

/// A chart with 28-pixel patches on black, on a grey ground, by quarter turns clockwise.
Image<std::uint16_t> chart_picture(int turns) {
  const auto& reflectances = synthetic::chart_reflectances();
  const int width = 6 * pitch + 160;
  const int height = 4 * pitch + 120;
  const auto colour = [&](int x, int y, int channel) {
    const int column = (x - 80 + pitch) / pitch - 1;
    const int row = (y - 60 + pitch) / pitch - 1;
    if (x < 70 || y < 50 || x >= width - 70 || y >= height - 50) return code_of(0.35);
    const int within_x = x - 80 - column * pitch;
    const int within_y = y - 60 - row * pitch;
    const bool patch = column >= 0 && column < 6 && row >= 0 && row < 4 && within_x >= 6 &&
                       within_x < pitch - 6 && within_y >= 6 && within_y < pitch - 6;
    if (!patch) return code_of(0.02);
    return code_of(reflectances[static_cast<std::size_t>(6 * row + column)]
                               [static_cast<std::size_t>(channel)]);
  };
  const bool across = turns % 2 == 1;
  Image<std::uint16_t> picture(across ? height : width, across ? width : height, 3);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      int u = x;
      int v = y;
      if (turns == 1) u = y, v = height - 1 - x;
      if (turns == 2) u = width - 1 - x, v = height - 1 - y;
      if (turns == 3) u = width - 1 - y, v = x;
      for (int c = 0; c < 3; ++c) {
        picture(x, y, c) = static_cast<std::uint16_t>(colour(u, v, c));
      }
    }
  }
  return picture;
}

class ChartPhotographTest : public TemporaryFolderTest {};

TEST_F(ChartPhotographTest, PatchesAreMeasuredInEveryTurn) {
  for (int turns = 0; turns < 4; ++turns) {
    io::write_code_image(folder() / "chart_photo.png", chart_picture(turns), 8);
    const ChartPhotograph chart = measure_chart_photograph(
        folder() / "chart_photo.png", capture::Encoding::response, std::nullopt, folder());
    EXPECT_GE(chart.outlines, 20) << turns;
    for (std::size_t p = 0; p < 24; ++p) {
      EXPECT_EQ(chart.patches[p].saturated, 0);
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(chart.patches[p].mean[c], code_of(synthetic::chart_reflectances()[p][c]), 1.0)
            << turns << " turns, " << chart.patches[p].name;
      }
    }
    for (const double slope : chart.neutral_slope) EXPECT_NEAR(slope, gamma_exponent, 0.01);
    EXPECT_TRUE(std::filesystem::exists(folder() / "chart.png"));
    EXPECT_TRUE(std::filesystem::exists(folder() / "chart.csv"));
  }
}

TEST_F(ChartPhotographTest, WhereNoneIsSeenCornersTellIt) {
  Image<std::uint16_t> picture(200, 150, 3, 90);
  io::write_code_image(folder() / "plain.png", picture, 8);
  EXPECT_THAT(
      [&] {
        measure_chart_photograph(folder() / "plain.png", capture::Encoding::response, {}, folder());
      },
      ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("the centres of four patches")));
  const ChartCorners corners{{{30, 30}, {160, 30}, {160, 110}, {30, 110}}};
  const ChartPhotograph chart = measure_chart_photograph(
      folder() / "plain.png", capture::Encoding::response, corners, folder());
  EXPECT_EQ(chart.patches[7].mean[1], 90.0);
  EXPECT_EQ(chart.patches[7].deviation[1], 0.0);
  EXPECT_THAT(
      [&] {
        measure_chart_photograph(folder() / "plain.png", capture::Encoding::response,
                                 ChartCorners{{{300, 30}, {460, 30}, {460, 110}, {300, 110}}},
                                 folder());
      },
      ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("no pixel in the picture")));
}

TEST_F(ChartPhotographTest, GreyPhotographsAreRefused) {
  io::write_code_image(folder() / "grey.png", Image<std::uint16_t>(60, 60, 1, 40), 8);
  EXPECT_THAT(
      [&] {
        measure_chart_photograph(folder() / "grey.png", capture::Encoding::response, {}, folder());
      },
      ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("one channel")));
}

}  // namespace
}  // namespace kappamu::pipeline
