// What gnuplot makes of charts, seen as pixels. That axes are legible a person has to look at.
#include "bench/chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>

#include "core/error.h"
#include "io/image_file.h"
#include "tests/bench/bench_tools.h"

namespace kappamu::bench {

namespace {

using testing::HasSubstr;

Chart two_lines() {
  Chart chart;
  chart.title = "two lines";
  chart.x_label = "error";
  chart.y_label = "seconds";
  chart.log_x = chart.log_y = true;
  chart.series = {{"first", {1e-2, 1e-4, 1e-6}, {0.1, 0.2, 0.3}, {}, {}, {}},
                  {"second", {1e-2, 1e-4, 0.0}, {1.0, 2.0, 3.0}, {}, {}, {}}};
  return chart;
}

using ChartTest = FolderTest;

TEST_F(ChartTest, PictureHasTheColoursOfItsSeries) {
  const auto png = folder() / "chart.png";
  draw(std::vector{two_lines()}, png, 1, 640, 480);
  const Image<std::uint16_t> picture = io::read_code_image(png);
  ASSERT_EQ(picture.width(), 640);
  ASSERT_EQ(picture.height(), 480);
  ASSERT_EQ(picture.channels(), 3);
  using Colour = std::array<int, 3>;
  int blue = 0, orange = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Colour p{picture(x, y, 0), picture(x, y, 1), picture(x, y, 2)};
      blue += p == Colour{0x00, 0x72, 0xB2} ? 1 : 0;
      orange += p == Colour{0xD5, 0x5E, 0x00} ? 1 : 0;
    }
  }
  EXPECT_GT(blue, 100);
  EXPECT_GT(orange, 100);
}

TEST_F(ChartTest, ScriptBesideThePictureRemakesIt) {
  const auto png = folder() / "chart.png";
  draw(std::vector{two_lines()}, png, 1, 640, 480);
  const Image<std::uint16_t> before = io::read_code_image(png);
  std::filesystem::remove(png);
  ASSERT_EQ(std::system(("cd '" + folder().string() + "' && gnuplot chart.gp").c_str()), 0);
  const Image<std::uint16_t> after = io::read_code_image(png);
  ASSERT_TRUE(after.same_shape(before));
  EXPECT_EQ(after.values(), before.values());
}

TEST_F(ChartTest, RasterOfChartsIsAsLargeAsItsParts) {
  draw(std::vector{two_lines(), two_lines(), two_lines()}, folder() / "three.png", 2, 400, 300);
  const Image<std::uint16_t> picture = io::read_code_image(folder() / "three.png");
  EXPECT_EQ(picture.width(), 800);
  EXPECT_EQ(picture.height(), 600);
}

TEST_F(ChartTest, SeriesOfUnequalLengthsIsRefused) {
  Chart chart = two_lines();
  chart.series[1].y.pop_back();
  EXPECT_THAT([&] { draw(std::vector{chart}, folder() / "c.png"); },
              testing::ThrowsMessage<InputError>(HasSubstr("'second' has unequal lengths")));
}

TEST_F(ChartTest, ChartWithoutAPointIsRefused) {
  Chart chart = two_lines();
  for (Series& series : chart.series) series.y = {0.0, 0.0, 0.0};
  EXPECT_THAT([&] { draw(std::vector{chart}, folder() / "c.png"); },
              testing::ThrowsMessage<InputError>(HasSubstr("no point to draw")));
  EXPECT_FALSE(std::filesystem::exists(folder() / "c.png"));
}

}  // namespace
}  // namespace kappamu::bench
