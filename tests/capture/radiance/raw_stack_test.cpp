// RAW stacks: the sensor's codes reach radiance unchanged, the merge is done site by site and its
// variance is right after demosaicing too.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "capture/radiance/demosaic.h"
#include "capture/radiance/merge.h"
#include "capture/session/bayer.h"
#include "capture/session/frames.h"
#include "tests/capture/session_files.h"
#include "tests/capture/simulated_camera.h"
#include "tests/sentence.h"

namespace kappamu::capture {
namespace {

constexpr io::BayerLayout rggb{0, 1, 1, 2};

Radiometry radiometry_of(const SimulatedCamera& camera, std::optional<int> white = std::nullopt) {
  Radiometry radiometry;
  radiometry.bit_depth = camera.bit_depth;
  for (int c = 0; c < 3; ++c) {
    radiometry.black_level.push_back(camera.black_code);
    radiometry.response.linear.push_back(
        linear_response(camera.bit_depth, camera.black_code, white));
    radiometry.noise.push_back({camera.electrons_full_scale, camera.read_noise_electrons, false});
  }
  return radiometry;
}

TEST(Bayer, DemosaicKeepsEverySitesOwnCodeAndPlanes) {
  Image<std::uint16_t> mosaic(8, 6, 1);
  // A plane in x and y per colour: bilinear interpolation is exact inside.
  const auto plane = [](int x, int y, int c) { return 100 * (c + 1) + 8 * x + 4 * y; };
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 8; ++x) {
      mosaic(x, y) = static_cast<std::uint16_t>(
          plane(x, y, rggb[static_cast<std::size_t>(2 * (y % 2) + x % 2)]));
    }
  }
  const Image<std::uint16_t> image = demosaic(mosaic, rggb);
  for (int y = 1; y < 5; ++y) {
    for (int x = 1; x < 7; ++x) {
      for (int c = 0; c < 3; ++c) EXPECT_EQ(image(x, y, c), plane(x, y, c)) << x << y << c;
    }
  }
  EXPECT_EQ(image(0, 0, 0), mosaic(0, 0));
}

TEST(Bayer, MergedVarianceIsRightAfterDemosaicing) {
  const SimulatedCamera camera{14, 2048.0, 15000.0, 8.0, straight_curve};
  const std::array<float, 3> colour{0.02F, 0.3F, 1.5F};
  Image<float> scene(200, 160, 1);
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 200; ++x) {
      scene(x, y) =
          colour[static_cast<std::size_t>(rggb[static_cast<std::size_t>(2 * (y % 2) + x % 2)])];
    }
  }
  std::vector<ExposedFrame> packed;
  for (const ExposedFrame& frame : shoot_stack(camera, scene, {1.0 / 30.0, 0.2, 1.0}, 8)) {
    packed.push_back({pack_sites(frame.pixels), frame.exposure_s});
  }
  const HdrImage image = demosaic(
      merge_frames(packed, site_radiometry(radiometry_of(camera), rggb), "simulated"), rggb);
  for (int c = 0; c < 3; ++c) {
    double mean = 0.0;
    double predicted = 0.0;
    double count = 0.0;
    for (int y = 2; y < 158; ++y) {
      for (int x = 2; x < 198; ++x) {
        mean += image.radiance(x, y, c);
        predicted += image.variance(x, y, c);
        count += 1.0;
      }
    }
    mean /= count;
    double variance = 0.0;
    for (int y = 2; y < 158; ++y) {
      for (int x = 2; x < 198; ++x) {
        const double off = image.radiance(x, y, c) - mean;
        variance += off * off / count;
      }
    }
    const double truth = colour[static_cast<std::size_t>(c)];
    std::printf("channel %d: bias %+.1e, predicted/sampled variance %.3f\n", c, mean / truth - 1.0,
                predicted / count / variance);
    EXPECT_NEAR(mean / truth, 1.0, 2e-3);
    // Sampled over 30000 correlated pixels: 1 to 2 %.
    EXPECT_NEAR(predicted / count / variance, 1.0, 0.05);
  }
}

TEST(WhiteLevel, IsFullScaleAndSaturation) {
  const std::vector<double> linear = linear_response(14, 2048.0, 15000);
  EXPECT_EQ(linear[2048], 0.0);
  EXPECT_EQ(linear[15000], 1.0);
  EXPECT_EQ(linear[16383], 1.0);
  EXPECT_EQ(saturation_code(linear), 14850);
  EXPECT_EQ(saturation_code(linear_response(12, 40.0)), saturation_code(12));
}

class RealRawStack : public testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path folder =
        std::filesystem::path(KAPPAMU_SOURCE_DIR) / ".." / "shared" / "data" / "raw-dng-colorchart";
    if (!std::filesystem::exists(folder / "colorchart.dng")) {
      GTEST_SKIP() << "the real RAW is not beside the sources";
    }
    session.folder = folder;
    session.camera = {1734, 1156, 14, Encoding::linear, 15000, {}, {}};
  }
  Session session;
  const Frame frame{"colorchart.dng", 0.25};
};

TEST_F(RealRawStack, CodesReachRadianceUnchanged) {
  const SimulatedCamera camera{14, 2048.0, 25000.0, 10.0, straight_curve};
  const Radiometry radiometry = radiometry_of(camera, 15000);
  const HdrImage merged = merge_stack(session, {frame}, "chart", radiometry);
  const io::RawImage raw = load_raw_frame(session, frame);
  ASSERT_EQ(merged.radiance.width(), 1734);
  double worst = 0.0;
  for (int y = 0; y < 1156; ++y) {
    for (int x = 0; x < 1734; ++x) {
      const int c = (*raw.layout)[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
      const double expected = (raw.codes(x, y) - 2048.0) / (15000.0 - 2048.0) / 0.25;
      worst = std::max(worst, std::abs(merged.radiance(x, y, c) - expected));
    }
  }
  EXPECT_LT(worst, 1e-6);  // single precision of numbers below 4
  EXPECT_EQ(load_frame(session, frame).channels(), 3);
  EXPECT_EQ(load_sites(session, frame).width(), 867);
}

TEST_F(RealRawStack, AnotherWhiteLevelOrACurveIsRefused) {
  session.camera.white_level = 16000;
  EXPECT_THAT(
      sentence_of([&] { load_frame(session, frame); }),
      testing::AllOf(testing::HasSubstr("colorchart.dng: the sensor saturates at code 15000"),
                     testing::HasSubstr("another photograph at 16000; give photographs of one")));
  session.camera.encoding = Encoding::response;
  EXPECT_THAT(sentence_of([&] { load_frame(session, frame); }),
              testing::HasSubstr("this RAW frame is linear"));
}

}  // namespace
}  // namespace kappamu::capture
