// Opening frames: bad files are told by name. Damage inside the file formats is io's test.
#include "capture/session/frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "capture/radiance/merge.h"
#include "capture/response/dark_frames.h"
#include "capture/response/photon_transfer.h"
#include "io/image/image_file.h"
#include "tests/capture/session_files.h"
#include "tests/capture/simulated_camera.h"
#include "tests/io/image/plain_tiff.h"
#include "tests/sentence.h"

namespace kappamu::capture {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class Frames : public testing::Test {
 protected:
  Frames() {
    session.folder = folder.path();
    session.camera.width = 40;
    session.camera.height = 30;
    session.camera.bit_depth = 12;
  }
  std::string error_of(const std::string& file) {
    return sentence_of([&] { load_frame(session, {file, 0.1}); });
  }
  std::string path(const std::string& file) const { return (folder.path() / file).string(); }

  OwnFolder folder;
  Session session;
};

TEST_F(Frames, AGoodFrameComesBackCodeForCode) {
  Image<std::uint16_t> codes(40, 30, 3);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    codes.values()[i] = static_cast<std::uint16_t>(i * 37 % 4096);
  }
  for (const char* name : {"a.png", "a.tif"}) {
    io::write_image(path(name), codes);
    EXPECT_EQ(load_frame(session, {name, 0.1}).values(), codes.values()) << name;
  }
}

// At the picture's edges and within, turned or not, with a filled border that reaches into the part
// from beyond it.
TEST_F(Frames, APartIsThatOfTheWhole) {
  Image<std::uint16_t> codes(40, 30, 3);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    codes.values()[i] = static_cast<std::uint16_t>(200 + i * 37 % 3000);
  }
  io::write_image(path("plain.png"), codes);
  io::write_image(path("plain.tif"), codes);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < (y < 20 ? 3 : 20); ++x) {
      for (int c = 0; c < 3; ++c) codes(x, y, c) = c == 1 ? 0 : 4095;
    }
  }
  io::write_image(path("filled.png"), codes);
  io::write_float_image(path("linear.exr"), Image<float>(40, 30, 3, 0.3F));
  EXPECT_EQ(load_frame(session, {"filled.png", 0.1})(10, 25, 1), 4095) << "the border is seen";
  const std::vector<Region> parts{{0, 0, 40, 30}, {8, 8, 16, 8}, {0, 16, 24, 14}, {32, 24, 8, 6}};
  for (const Encoding encoding : {Encoding::response, Encoding::linear}) {
    for (const int orientation : {1, 3}) {
      for (const char* name : {"plain.png", "plain.tif", "filled.png", "linear.exr"}) {
        session.camera.encoding = encoding;
        session.camera.orientation = orientation;
        const Frame frame{name, 0.1};
        const Image<std::uint16_t> whole = load_frame(session, frame);
        for (const Region& part : parts) {
          const std::vector<std::uint16_t> expected = cropped(whole, part).values();
          EXPECT_EQ(load_frame(session, frame, part).values(), expected) << name << part.left;
          Image<std::uint16_t> by_rows(part.width, part.height, 3);
          load_rows(
              session, frame,
              [&](int y, const std::uint16_t* row) {
                std::copy_n(row, 3 * part.width, &by_rows(0, y));
              },
              part);
          EXPECT_EQ(by_rows.values(), expected) << name << part.left;
        }
      }
    }
  }
}

TEST_F(Frames, AStackOfAPartIsMergedAsTheWhole) {
  session.camera.width = 64;
  session.camera.height = 48;
  session.camera.encoding = Encoding::linear;
  Radiometry radiometry;
  radiometry.bit_depth = 12;
  radiometry.black_level = {10.0, 10.0, 10.0};
  radiometry.response.linear.assign(3, linear_response(12, 10.0));
  radiometry.noise.assign(3, {20000.0, 5.0});
  Stack stack;
  for (const double exposure : {0.1, 0.3, 1.0}) {
    Image<std::uint16_t> codes(64, 48, 3);
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) {
        for (int c = 0; c < 3; ++c) {
          const double light = 0.1 + 0.002 * x + 0.003 * y + 0.2 * c + 0.05 * (x * 7 % 5);
          codes(x, y, c) = static_cast<std::uint16_t>(
              std::min(4095.0, 10.0 + std::round(4085.0 * light * exposure)));
        }
      }
    }
    stack.push_back({"frame_" + std::to_string(stack.size()) + ".png", exposure});
    io::write_image(path(stack.back().file), codes);
  }
  const HdrImage whole = merge_stack(session, stack, "whole", radiometry);
  EXPECT_EQ(whole.place(), (Region{0, 0, 64, 48}));
  for (const Region& part : {Region{8, 16, 24, 24}, Region{0, 0, 64, 8}, Region{56, 40, 8, 8}}) {
    MergeOptions options;
    options.part = part;
    const HdrImage merged = merge_stack(session, stack, "part", radiometry, options);
    EXPECT_EQ(merged.place(), part);
    EXPECT_EQ(merged.radiance.values(), cropped(whole.radiance, part).values());
    EXPECT_EQ(merged.variance.values(), cropped(whole.variance, part).values());
    EXPECT_EQ(merged.flags.values(), cropped(whole.flags, part).values());
  }
}

// Three colours a pixel (linear DNG) are merged as a TIFF of the same codes is.
TEST_F(Frames, LinearDngIsMergedAsItsCodes) {
  io::Page page = io::dng(false, {});
  page.samples = 3;
  Image<std::uint16_t> codes(64, 48, 3);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    codes.values()[i] = static_cast<std::uint16_t>(64 + 911 * i % 60000);
    io::put_number(page.pixels, codes.values()[i], 2);
  }
  write_text(path("a.dng"), io::tiff({page}));
  io::write_image(path("a.tif"), codes);
  session.camera = {64, 48, 16, Encoding::linear, 65000, {}, {}};
  const Frame raw{"a.dng", 0.1}, plain{"a.tif", 0.1};
  EXPECT_EQ(load_frame(session, raw).values(), codes.values());
  EXPECT_EQ(load_sites(session, raw).values(), codes.values());
  const Region part{7, 5, 31, 20};
  EXPECT_EQ(load_frame(session, raw, part).values(), cropped(codes, part).values());
  Radiometry radiometry;
  radiometry.bit_depth = 16;
  radiometry.black_level = {64.0, 64.0, 64.0};
  radiometry.response.linear.assign(3, linear_response(16, 64.0, 65000));
  radiometry.noise.assign(3, {20000.0, 5.0});
  const HdrImage merged = merge_stack(session, {raw}, "raw", radiometry);
  const HdrImage expected = merge_stack(session, {plain}, "plain", radiometry);
  EXPECT_EQ(merged.radiance.values(), expected.radiance.values());
  EXPECT_EQ(merged.variance.values(), expected.variance.values());
  session.camera.orientation = 3;
  EXPECT_EQ(load_frame(session, raw)(0, 0, 2), codes(63, 47, 2));
  session.channels = {"Y"};
  EXPECT_THAT(error_of("a.dng"), HasSubstr("has channels R, G, B"));
}

TEST_F(Frames, HeaderlessRawIsReadByItsDescribedLayout) {
  const auto code = [](int x, int y) { return (41 * x + 7 * y) % 4096; };
  std::string big(5, '!');
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      big += {static_cast<char>(code(x, y) >> 8), static_cast<char>(code(x, y) & 255)};
    }
  }
  write_text(path("a.raw"), big);
  session.camera.encoding = Encoding::linear;
  session.camera.raw_layout = io::RawLayout{16, true, 5, io::BayerLayout{1, 2, 0, 1}};
  const io::RawImage raw = load_raw_frame(session, {"a.raw", 0.1});
  EXPECT_EQ(raw.layout, (io::BayerLayout{1, 2, 0, 1}));
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) ASSERT_EQ(raw.codes(x, y), code(x, y)) << x << ", " << y;
  }
  EXPECT_EQ(load_frame(session, {"a.raw", 0.1}).channels(), 3);

  session.channels = {"Y"};
  session.camera.raw_layout->mosaic.reset();
  EXPECT_EQ(load_frame(session, {"a.raw", 0.1}).values(), raw.codes.values());
  session.camera.raw_layout->offset = 4;
  EXPECT_THAT(
      error_of("a.raw"),
      AllOf(StartsWith(path("a.raw") + ": the file has 2405 bytes, but 40 x 30 codes of 16"),
            HasSubstr("from byte 4 on have 2404")));
  session.camera.raw_layout->offset = 5;
  session.camera.raw_layout->big_endian = false;
  EXPECT_THAT(error_of("a.raw"), HasSubstr("fits into fewer bits: 12"));
  write_text(path("b.raw"), std::string(1200, '\x81'));
  session.camera.bit_depth = 8;
  session.camera.raw_layout = io::RawLayout{8, false, 0, {}};
  EXPECT_EQ(load_frame(session, {"b.raw", 0.1})(39, 29), 0x81);
}

TEST_F(Frames, AMissingFrameIsNamed) {
  EXPECT_THAT(error_of("frames/none.png"),
              AllOf(StartsWith(path("frames/none.png") + ": no such frame"),
                    HasSubstr("put it back"), testing::EndsWith(".")));
}

TEST_F(Frames, ATruncatedFrameIsNamed) {
  io::write_image(path("whole.png"), Image<std::uint16_t>(40, 30, 3, 1234));
  io::write_image(path("whole.tif"), Image<std::uint16_t>(40, 30, 3, 1234));
  io::write_float_image(path("whole.exr"), Image<float>(40, 30, 3, 0.3F));
  for (const char* extension : {".png", ".tif", ".exr"}) {
    const std::string bytes = read_text(path(std::string("whole") + extension));
    for (const double share : {0.0, 0.3, 0.9}) {
      const std::string name = std::string("cut") + extension;
      write_text(
          path(name),
          bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
      EXPECT_THAT(error_of(name), StartsWith(path(name))) << extension << " " << share;
    }
  }
}

TEST_F(Frames, AWrongSizedFrameIsNamedWithBothSizes) {
  write_text(path("session.json"), "{}");
  io::write_image(path("small.png"), Image<std::uint16_t>(39, 30, 3, 9));
  EXPECT_THAT(error_of("small.png"),
              AllOf(StartsWith(path("small.png") + ": the frame is 39 x 30 pixels"),
                    HasSubstr("camera.width x camera.height = 40 x 30")));
}

TEST_F(Frames, AWrongNumberOfChannelsIsNamed) {
  io::write_image(path("grey.png"), Image<std::uint16_t>(40, 30, 1, 9));
  EXPECT_THAT(error_of("grey.png"),
              HasSubstr("the frame has 1 channels, the other photographs have 3"));
  write_text(path("session.json"), "{}");
  EXPECT_THAT(error_of("grey.png"), HasSubstr("session.json lists 3 in channels"));
}

TEST_F(Frames, CodesBeyondTheBitDepthAreToldWithTheFix) {
  write_text(path("session.json"), "{}");
  io::write_image(path("shifted.png"), Image<std::uint16_t>(40, 30, 3, 4096));
  EXPECT_THAT(error_of("shifted.png"),
              AllOf(HasSubstr("holds code 4096"), HasSubstr("camera.bit_depth = 12"),
                    HasSubstr("store the codes unshifted")));
}

TEST_F(Frames, ExrFramesAreLinearFractionsOfFullScale) {
  Image<float> linear(40, 30, 3, 0.5F);
  linear(1, 0, 0) = -0.1F;
  linear(2, 0, 0) = 7.0F;
  io::write_float_image(path("a.exr"), linear);
  const Image<std::uint16_t> codes = load_frame(session, {"a.exr", 0.1});
  EXPECT_EQ(codes(0, 0, 0), 2048);
  EXPECT_EQ(codes(1, 0, 0), 0);
  EXPECT_EQ(codes(2, 0, 0), 4095);
  EXPECT_EQ(load_float_frame(session, {"a.exr", 0.1})(2, 0, 0), 7.0F);
  linear(3, 2, 1) = std::nanf("");
  io::write_float_image(path("nan.exr"), linear);
  EXPECT_THAT(error_of("nan.exr"), HasSubstr("pixel (3, 2) is not finite"));
}

TEST_F(Frames, NumbersOfAnotherScaleAreRefusedByTheirCause) {
  io::write_image(path("narrow.png"), Image<std::uint8_t>(40, 30, 3, 90));
  EXPECT_THAT(error_of("narrow.png"),
              AllOf(HasSubstr("narrow.png: the frame is stored with 8 bits per channel"),
                    HasSubstr("another photograph with 16")));
  io::write_float_image(path("codes.exr"), Image<float>(40, 30, 3, 3000.0F));
  EXPECT_THAT(error_of("codes.exr"), HasSubstr("holds 3000, and 1 is where the sensor saturates"));
}

TEST_F(Frames, AStackSaturatedThroughoutNamesFilePatternAndFix) {
  io::write_image(path("a.png"), Image<std::uint16_t>(40, 30, 3, 4095));
  io::write_image(path("b.png"), Image<std::uint16_t>(40, 30, 3, 4095));
  std::ofstream(path("session.json")) << "{}";  // without one, the folder is named
  Radiometry radiometry;
  radiometry.bit_depth = 12;
  radiometry.black_level.assign(3, 0.0);
  radiometry.response.linear.assign(3, linear_response(12, 0.0));
  radiometry.noise.assign(3, {20000.0, 5.0, false});
  EXPECT_EQ(sentence_of([&] {
              merge_stack(session, {{"a.png", 0.5}, {"b.png", 2.0}}, "pattern fit_03", radiometry);
            }),
            path("session.json") + ": pattern fit_03: every pixel is saturated in all 2 frames; " +
                "add exposures shorter than 0.5 s.");
}

std::vector<long> dark_histogram(double level, double deviation, bool clipped) {
  const SimulatedCamera camera{12, level, 1000.0, deviation / 4095.0 * 1000.0, straight_curve};
  const Image<float> nothing(200, 200, 1, 0.0F);
  std::vector<long> histogram(4096, 0);
  const auto stack = shoot_stack(camera, nothing, {0.1}, 77);
  for (const std::uint16_t code : stack[0].pixels.values()) ++histogram[code];
  if (!clipped) {
    histogram[4000] += 5;  // hot pixels
  }
  return histogram;
}

TEST(DarkLevel, IsTheMeanOfTheBulkWithItsDeviation) {
  const DarkLevel level = dark_level(dark_histogram(40.3, 4.0, false));
  // 40000 pixels: the mean is known to 0.02 codes, the deviation to 0.014; five of those each.
  EXPECT_NEAR(level.code, 40.3, 0.1);
  EXPECT_NEAR(level.deviation, std::sqrt(16.0 + 1.0 / 12.0), 0.08);
}

TEST(DarkLevel, OfACameraThatCutsAtZeroIsNotPulledUpByTheHalfThatIsLeft) {
  const DarkLevel level = dark_level(dark_histogram(0.0, 6.0, true));
  EXPECT_EQ(level.code, 0.0);
  EXPECT_NEAR(level.deviation, 6.0, 1.0);
}

TEST(PhotonTransfer, FindsTheElectronsWhateverTheTexture) {
  for (const double electrons : {3000.0, 20000.0}) {
    const SimulatedCamera camera{12, 40.0, electrons, 5.0, straight_curve};
    Image<float> scene = smooth_scene(300, 200, 1, 0.05, 20.0);
    for (std::size_t i = 0; i < scene.size(); ++i) {
      scene.values()[i] *= 1.0F + 0.5F * static_cast<float>(i * 7919 % 101) / 101.0F;
    }
    const auto stack = shoot_stack(camera, scene, seven_exposures(), 4);
    const std::optional<double> found =
        electrons_at_full_scale(stack, 0, linear_response(12, 40.0), 5.0 / electrons);
    ASSERT_TRUE(found.has_value());
    std::printf("electrons at full scale: %.0f of %.0f\n", *found, electrons);
    EXPECT_NEAR(*found / electrons, 1.0, 0.05);
  }
}

TEST(PhotonTransfer, TellsNothingWhereReadNoiseRules) {
  const SimulatedCamera camera{12, 40.0, 20000.0, 50.0, straight_curve};
  const auto stack = shoot_stack(camera, Image<float>(100, 100, 1, 0.0005F), {0.1, 0.2}, 4);
  EXPECT_FALSE(
      electrons_at_full_scale(stack, 0, linear_response(12, 40.0), 50.0 / 20000.0).has_value());
}

}  // namespace
}  // namespace kappamu::capture
