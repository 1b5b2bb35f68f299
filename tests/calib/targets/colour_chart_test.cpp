// Real photographs of a ColorChecker: patches found, white balance and scale with their residuals,
// against means taken by hand-placed windows (shared/data, patch_means.csv beside each photograph).
// The simulated chart against the simulator's truth. Prints the tables of docs/hdr.md.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "calib/calibrate.h"
#include "calib/light/radiometry.h"
#include "calib/light/stray_light.h"
#include "calib/targets/chart.h"
#include "capture/radiance/chart_search.h"
#include "capture/radiance/merge.h"
#include "capture/session/bayer.h"
#include "capture/session/frames.h"
#include "data_synthetic/simulate.h"
#include "data_synthetic/truth.h"
#include "io/image/image_file.h"
#include "io/image/raw_file.h"
#include "tests/data_synthetic/tiny_options.h"
#include "tests/own_folder.h"

namespace kappamu::calib {
namespace {

std::filesystem::path data_folder() {
  return std::filesystem::path(KAPPAMU_SOURCE_DIR) / ".." / "shared" / "data";
}

/// A patch as patch_means.csv has it: window centre [px], means of R, G, B in the file's codes.
struct Window {
  double x = 0.0;
  double y = 0.0;
  std::array<double, 3> mean{};
};

std::vector<Window> windows_of(const std::filesystem::path& folder) {
  std::ifstream in(folder / "patch_means.csv");
  std::vector<Window> windows;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    int patch = 0;
    Window w;
    fields >> patch >> w.x >> w.y >> w.mean[0] >> w.mean[1] >> w.mean[2];
    windows.push_back(w);
  }
  return windows;
}

/// Linear light of a photograph, without noise model or flags.
template <class ToLight>
capture::HdrImage as_radiance(const Image<std::uint16_t>& codes, const ToLight& light) {
  capture::HdrImage image;
  image.radiance = Image<float>(codes.width(), codes.height(), codes.channels());
  image.variance = Image<float>(codes.width(), codes.height(), codes.channels(), 1.0F);
  image.flags = Image<std::uint8_t>(codes.width(), codes.height(), codes.channels(), 0);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    image.radiance.values()[i] = static_cast<float>(light(codes.values()[i]));
  }
  return image;
}

/// Finds the chart in `codes` and measures it; `light` takes codes, and the windows' means, to
/// linear light.
template <class ToLight>
ChartReference measure(const char* name, const Image<std::uint16_t>& codes,
                       capture::Encoding encoding, const std::vector<Window>& windows,
                       const ToLight& light) {
  const auto place = capture::find_chart_place(codes, encoding);
  EXPECT_TRUE(place) << name;
  if (!place) return {};
  EXPECT_GE(place->patches, 18) << name;
  std::array<Eigen::Vector2d, 4> corners;
  for (std::size_t k = 0; k < 4; ++k)
    corners[k] = {place->corners_px[k][0], place->corners_px[k][1]};
  const ChartPatches patches = chart_from_corners(corners);
  const double pitch = (patches.centres[1] - patches.centres[0]).norm();
  double farthest = 0.0;
  for (std::size_t p = 0; p < windows.size(); ++p) {
    farthest = std::max(farthest,
                        (patches.centres[p] - Eigen::Vector2d(windows[p].x, windows[p].y)).norm());
  }
  // The windows were placed on an upright grid by eye; half a patch is 0.42 of the pitch.
  EXPECT_LT(farthest, 0.25 * pitch) << name;

  const ChartReference chart = measure_chart(as_radiance(codes, light), patches, nullptr, 1.0, {});
  EXPECT_EQ(chart.scale.size(), 3U);
  std::printf("%s: %d of 24 patches outlined, windows within %.2f of the pitch\n", name,
              place->patches, farthest / pitch);
  std::array<double, 3> by_windows{};
  const std::array<double, 6> published = neutral_reflectances();
  for (std::size_t c = 0; c < 3; ++c) {
    double products = 0.0;
    double squares = 0.0;
    for (std::size_t k = 0; k < 6; ++k) {
      products += light(windows[18 + k].mean[c]) * published[k];
      squares += published[k] * published[k];
    }
    by_windows[c] = products / squares * std::numbers::pi;
  }
  std::printf(
      "  white balance R/G %.4f B/G %.4f (by windows %.4f %.4f), scale %.5f %.5f %.5f (%+.2f %+.2f "
      "%+.2f %%)\n",
      chart.scale[0] / chart.scale[1], chart.scale[2] / chart.scale[1],
      by_windows[0] / by_windows[1], by_windows[2] / by_windows[1], chart.scale[0], chart.scale[1],
      chart.scale[2], 100.0 * (chart.scale[0] / by_windows[0] - 1.0),
      100.0 * (chart.scale[1] / by_windows[1] - 1.0),
      100.0 * (chart.scale[2] / by_windows[2] - 1.0));
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(chart.scale[c], by_windows[c], 0.01 * by_windows[c]) << name << " channel " << c;
  }
  for (const NeutralPatch& neutral : chart.neutrals) {
    std::printf("  neutral %d: published %.4f, measured", neutral.patch + 1, neutral.published);
    for (const double value : neutral.measured) std::printf(" %.4f", value);
    std::printf("\n");
  }
  std::printf(
      "  residual RMS of the neutrals above 5 %%: %.1f %%, stray light %.2f %.2f %.2f %% of "
      "white\n",
      100.0 * chart.residual_rms, 100.0 * stray_light(chart, 0).value(),
      100.0 * stray_light(chart, 1).value(), 100.0 * stray_light(chart, 2).value());
  return chart;
}

/// Which way up the chart lies follows from its colours: the corner patches turn with the picture.
void expect_found_in_every_turn(const char* name, Image<std::uint16_t> codes,
                                capture::Encoding encoding) {
  auto expected = capture::find_chart_place(codes, encoding);
  ASSERT_TRUE(expected) << name;
  const double width_px = std::hypot(expected->corners_px[1][0] - expected->corners_px[0][0],
                                     expected->corners_px[1][1] - expected->corners_px[0][1]);
  for (int quarter = 1; quarter < 4; ++quarter) {
    Image<std::uint16_t> turned(codes.height(), codes.width(), codes.channels());
    for (int y = 0; y < codes.height(); ++y) {
      for (int x = 0; x < codes.width(); ++x) {
        for (int c = 0; c < codes.channels(); ++c) {
          turned(codes.height() - 1 - y, x, c) = codes(x, y, c);
        }
      }
    }
    for (std::array<double, 2>& corner : expected->corners_px) {
      corner = {codes.height() - 1 - corner[1], corner[0]};
    }
    codes = std::move(turned);
    const auto place = capture::find_chart_place(codes, encoding);
    ASSERT_TRUE(place) << name << ", " << quarter << " quarter turns";
    double farthest = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      farthest =
          std::max(farthest, std::hypot(place->corners_px[k][0] - expected->corners_px[k][0],
                                        place->corners_px[k][1] - expected->corners_px[k][1]));
    }
    std::printf("%s, %d quarter turns: corners within %.3f of the pitch, %d patches outlined\n",
                name, quarter, 5.0 * farthest / width_px, place->patches);
    EXPECT_LT(5.0 * farthest / width_px, 0.1) << name << ", " << quarter << " quarter turns";
  }
}

TEST(RealChart, RawPhotographGivesWhiteBalanceAndScale) {
  const std::filesystem::path folder = data_folder() / "raw-dng-colorchart";
  if (!std::filesystem::exists(folder / "colorchart.dng")) {
    GTEST_SKIP() << "shared/data/raw-dng-colorchart is not beside the source folder";
  }
  const io::RawImage raw = io::read_raw(folder / "colorchart.dng");
  constexpr double black = 2048.0;  // of the masked columns (SOURCE.md)
  std::vector<Window> windows = windows_of(folder);
  for (Window& w : windows) {
    for (double& mean : w.mean) mean += black;
  }
  const auto light = [&](double code) { return (code - black) / (raw.white - black); };
  const Image<std::uint16_t> codes = capture::demosaic(raw.codes, *raw.layout);
  expect_found_in_every_turn("RAW", codes, capture::Encoding::linear);
  const ChartReference chart = measure("RAW", codes, capture::Encoding::linear, windows, light);
  // The photograph's flare, 1.1 % of white (SOURCE.md: G = 1300 Y + 14.3), brightens the dark ones.
  EXPECT_LT(chart.residual_rms, 0.12);
  EXPECT_NEAR(stray_light(chart, 1).value(), 14.3 / 1300.0, 0.002);
}

TEST(RealChart, ProcessedPhotographInATurnIsFound) {
  const std::filesystem::path folder = data_folder() / "colorchecker-plantcv-classic";
  if (!std::filesystem::exists(folder / "classic.png")) {
    GTEST_SKIP() << "shared/data/colorchecker-plantcv-classic is not beside the source folder";
  }
  const auto srgb = [](double code) {
    const double v = code / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  const Image<std::uint16_t> codes = io::read_code_image(folder / "classic.png");
  expect_found_in_every_turn("PNG", codes, capture::Encoding::response);
  measure("PNG", codes, capture::Encoding::response, windows_of(folder), srgb);
}

TEST(SimulatedChart, GivesTheAbsoluteScaleWithinHalfAPercent) {
  const OwnFolder folder;
  Progress progress;
  synthetic::SimulationOptions options = synthetic::tiny_options();
  // The end of a recovered response is a factor of its own, which cancels against the white target
  // (docs/hdr.md); a linear camera's scale can be held against the truth.
  options.encoding = capture::Encoding::linear;
  synthetic::simulate(options, folder, "reference", progress);
  capture::Session session = capture::read_session(folder / "session");
  const synthetic::Truth truth = synthetic::read_truth(folder / "truth");
  const auto place = capture::find_chart_place(session, session.calibration.colour_chart->frames);
  ASSERT_TRUE(place);
  EXPECT_GE(place->patches, 18);
  const capture::Stack& stack = session.calibration.colour_chart->frames;
  expect_found_in_every_turn("simulated", capture::load_frame(session, stack[stack.size() / 2]),
                             capture::Encoding::linear);
  session.calibration.colour_chart->corners_px = place->corners_px;
  const CalibrationResult found = calibrate(session, progress);
  capture::HdrImage picture = capture::merge_stack(
      session, session.calibration.colour_chart->frames, "colour chart", found.radiometry);
  const capture::HdrImage white = capture::merge_stack(
      session, session.calibration.white_target->frames, "white target", found.radiometry);
  const ChartReference alone = measure_chart(picture, found.chart->patches, nullptr, 1.0, {});
  // Room light of one per cent of the projector's white.
  constexpr double room = 0.01;
  for (std::size_t i = 0; i < picture.radiance.size(); ++i) {
    picture.radiance.values()[i] +=
        static_cast<float>(room * truth.responsivity[i % 3] / std::numbers::pi);
  }
  const ChartReference in_a_lit_room =
      measure_chart(picture, found.chart->patches, &white,
                    session.calibration.white_target->reflectance, found.scale);
  std::printf("%d of 24 patches outlined, neutrals against the white target %.2f %%\n",
              place->patches, 100.0 * found.chart->residual_rms);
  for (std::size_t c = 0; c < 3; ++c) {
    const auto percent_off = [&](double scale) {
      return 100.0 * (scale / truth.responsivity[c] - 1.0);
    };
    std::printf(
        "scale %zu: by the white target %+.3f %%, by the chart in its light %+.3f %%, by the chart "
        "alone %+.3f %%\n",
        c, percent_off(found.scale[c]), percent_off(found.chart->scale[c]),
        percent_off(alone.scale[c]));
    EXPECT_LT(std::abs(percent_off(found.scale[c])), 0.5);
    EXPECT_LT(std::abs(percent_off(found.chart->scale[c])), 0.5);
    // Alone it takes the projector's light as even, 1 on every patch, and the chart is wide.
    EXPECT_LT(std::abs(percent_off(alone.scale[c])), 8.0);
    std::printf("  stray light %.3f %% of white, in a lit room (1 %%) %.3f %%\n",
                100.0 * stray_light(*found.chart, c).value(),
                100.0 * stray_light(in_a_lit_room, c).value());
    EXPECT_NEAR(stray_light(*found.chart, c).value(), 0.0, 0.001);
    EXPECT_NEAR(stray_light(in_a_lit_room, c).value(), room, 0.001);
  }
  EXPECT_LT(found.chart->residual_rms, 0.01);
}

}  // namespace
}  // namespace kappamu::calib
