// What gnuplot makes of charts, seen as pixels. That axes are legible a person has to look at.
#include "bench/chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "core/error.h"
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
  const cv::Mat picture = cv::imread(png.string());
  ASSERT_EQ(picture.cols, 640);
  ASSERT_EQ(picture.rows, 480);
  int blue = 0, orange = 0;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto p = picture.at<cv::Vec3b>(y, x);  // blue, green, red
      blue += p == cv::Vec3b(0xB2, 0x72, 0x00) ? 1 : 0;
      orange += p == cv::Vec3b(0x00, 0x5E, 0xD5) ? 1 : 0;
    }
  }
  EXPECT_GT(blue, 100);
  EXPECT_GT(orange, 100);
}

TEST_F(ChartTest, ScriptBesideThePictureRemakesIt) {
  const auto png = folder() / "chart.png";
  draw(std::vector{two_lines()}, png, 1, 640, 480);
  const cv::Mat before = cv::imread(png.string());
  std::filesystem::remove(png);
  ASSERT_EQ(std::system(("cd '" + folder().string() + "' && gnuplot chart.gp").c_str()), 0);
  const cv::Mat after = cv::imread(png.string());
  ASSERT_EQ(after.size(), before.size());
  EXPECT_EQ(cv::norm(before, after), 0.0);
}

TEST_F(ChartTest, RasterOfChartsIsAsLargeAsItsParts) {
  draw(std::vector{two_lines(), two_lines(), two_lines()}, folder() / "three.png", 2, 400, 300);
  const cv::Mat picture = cv::imread((folder() / "three.png").string());
  EXPECT_EQ(picture.cols, 800);
  EXPECT_EQ(picture.rows, 600);
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
