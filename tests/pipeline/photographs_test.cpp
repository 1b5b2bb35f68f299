// One stage of the work on photographs alone gives what the whole session's stage gives.
#include "pipeline/stages/photographs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <random>

#include "calib/calibration_file.h"
#include "capture/session/session.h"
#include "core/error.h"
#include "io/image/image_file.h"
#include "pipeline/stages/hdr_file.h"
#include "tests/app/process.h"
#include "tests/app/tiny_session.h"

namespace kappamu::pipeline {
namespace {

namespace fs = std::filesystem;

class Photographs : public TemporaryFolderTest {
 protected:
  /// A folder with copies of `frames` under names of shot `shot`, and lines of their table.
  void add(const capture::Session& session, const std::vector<capture::Frame>& frames,
           const std::string& shot) {
    fs::create_directories(folder() / "photographs");
    for (const capture::Frame& frame : frames) {
      const fs::path from = session.folder / frame.file;
      const std::string name = shot + "_" + std::to_string(count_++) + from.extension().string();
      fs::copy_file(from, folder() / "photographs" / name);
      table_ += name + "," + shot + "," + std::to_string(frame.exposure_s) + "\n";
    }
  }
  capture::PhotographSource source() const {
    std::ofstream(folder() / "table.csv") << table_;
    return {folder() / "photographs", folder() / "table.csv"};
  }
  Progress silent_;

 private:
  int count_ = 0;
  std::string table_ = "file,shot,exposure_s\n";
};

TEST_F(Photographs, OneBracketMergesAsItsSessionDoes) {
  const capture::Session session = capture::read_session(tiny_session());
  const capture::Pattern& pattern = session.patterns.front();
  add(session, pattern.frames, "lit");
  add(session, session.calibration.dark, "dark");
  const BracketSummary summary =
      merge_photographs(source(), session.camera.encoding, {}, folder() / "out", silent_);
  EXPECT_EQ(summary.frames, pattern.frames.size());
  EXPECT_EQ(summary.dark_frames, session.calibration.dark.size());

  const capture::HdrImage alone = read_hdr(folder() / "out" / "radiance.exr", session.channels);
  const capture::HdrImage together =
      read_hdr(tiny_run() / "hdr" / (pattern.id + ".exr"), session.channels);
  // A session's merge keeps the part that shows the sample, a bracket's all of the picture.
  double difference = 0.0, norm = 0.0;
  for (int y = 0; y < together.radiance.height(); ++y) {
    for (int x = 0; x < together.radiance.width(); ++x) {
      for (int c = 0; c < together.radiance.channels(); ++c) {
        const int left = x + together.left, top = y + together.top;
        if (alone.flags(left, top, c) != 0 || together.flags(x, y, c) != 0) continue;
        const double a = alone.radiance(left, top, c), b = together.radiance(x, y, c);
        difference += (a - b) * (a - b);
        norm += b * b;
      }
    }
  }
  // The response of one stack is not that of four.
  EXPECT_LT(std::sqrt(difference / norm), 0.02);
}

TEST_F(Photographs, WithoutDarkFramesBlackIsFoundInTheBracket) {
  const capture::Session session = capture::read_session(tiny_session());
  add(session, session.patterns.front().frames, "lit");
  const std::vector<double> measured = capture::find_radiometry(session, silent_).black_level;
  const capture::Session bracket =
      capture::bracket_session(source(), session.camera.encoding, silent_);
  const std::vector<double> found = capture::find_radiometry(bracket, silent_).black_level;
  ASSERT_EQ(found.size(), measured.size());
  const double full = std::ldexp(1.0, session.camera.bit_depth);
  for (std::size_t c = 0; c < found.size(); ++c) EXPECT_NEAR(found[c], measured[c], 0.01 * full);
}

/// A frame as a scanner leaves it: film's bent response above a pedestal, grain, and a border of
/// pure blue where registering the scans moved the picture.
Image<std::uint16_t> scanned_frame(double exposure_s, int border, unsigned seed) {
  constexpr std::array<double, 3> pedestal{13.0, 18.0, 16.0};
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Image<std::uint16_t> codes(192, 128, 3);
  for (int y = 0; y < codes.height(); ++y) {
    for (int x = 0; x < codes.width(); ++x) {
      const double radiance =
          1e-3 * std::pow(10.0, 4.5 * x / codes.width()) * (1.0 + 0.2 * std::sin(0.3 * y));
      for (int c = 0; c < 3; ++c) {
        const double light = 0.02 * radiance * exposure_s * (1.0 + 0.04 * normal(random));
        const double film = std::pow(1.0 - std::exp(-light), 0.7);
        const double base = pedestal[static_cast<std::size_t>(c)];
        const double code = base + (255.0 - base) * film + normal(random);
        codes(x, y, c) = static_cast<std::uint16_t>(std::clamp(std::lround(code), 0L, 255L));
      }
      if (y < border || x < border / 2) {
        codes(x, y, 0) = codes(x, y, 1) = 0;
        codes(x, y, 2) = 255;
      }
    }
  }
  return codes;
}

TEST_F(Photographs, AScannedBracketWithBordersAndGrainIsNotAccused) {
  fs::create_directories(folder() / "photographs");
  std::string table = "file,shot,exposure_s\n";
  for (int i = 0; i < 14; ++i) {
    const double exposure_s = std::ldexp(16.0, -i);
    const std::string name = "scan_" + std::to_string(i) + ".png";
    io::write_code_image(folder() / "photographs" / name,
                         scanned_frame(exposure_s, (7 * i) % 9, 3U + static_cast<unsigned>(i)), 8);
    table += name + ",lit," + std::to_string(exposure_s) + "\n";
  }
  std::ofstream(folder() / "table.csv") << table;
  const capture::PhotographSource scans{folder() / "photographs", folder() / "table.csv"};
  merge_photographs(scans, capture::Encoding::response, {}, folder() / "out", silent_);
  const capture::HdrImage merged = read_hdr(folder() / "out" / "radiance.exr", {"R", "G", "B"});
  // Radiance up to one factor, along the picture's lower middle, from a dozen codes above black in
  // the longest exposure to two and a half decades more.
  std::vector<double> ratios;
  for (int x = 70; x < 180; ++x) {
    double sum = 0.0;
    for (int y = 90; y < 100; ++y) {
      sum += merged.radiance(x, y, 1) / (1.0 + 0.2 * std::sin(0.3 * y)) / 10.0;
    }
    ratios.push_back(std::log(sum / (1e-3 * std::pow(10.0, 4.5 * x / 192.0))));
  }
  std::nth_element(ratios.begin(), ratios.begin() + 55, ratios.end());
  const double middle = ratios[55];
  for (const double ratio : ratios) EXPECT_NEAR(ratio, middle, 0.1);
}

/// Codes of 12 bits among codes of 16, both in 16-bit files, without dark frames: the black level
/// that such frames suggest must not pass for noise.
TEST_F(Photographs, ADarkerScaleOfCodesIsReported) {
  fs::create_directories(folder() / "photographs");
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto write = [&](const char* name, double exposure_s, int shift) {
    Image<std::uint16_t> codes(160, 120, 1);
    for (int y = 0; y < codes.height(); ++y) {
      for (int x = 0; x < codes.width(); ++x) {
        const double light =
            65535.0 * exposure_s * (1.0 + 0.05 * x + 2.0 * std::sin(0.1 * y) + 2.0);
        codes(x, y) = static_cast<std::uint16_t>(
            std::lround(light + std::sqrt(3.0 * light) * normal(random)));
        codes(x, y) = static_cast<std::uint16_t>(codes(x, y) >> shift);
      }
    }
    io::write_code_image(folder() / "photographs" / name, codes, 16);
  };
  std::ofstream(folder() / "table.csv") << "file,shot,exposure_s\na.png,lit,0.02\nb.png,lit,0.07\n";
  const capture::PhotographSource bracket{folder() / "photographs", folder() / "table.csv"};
  const auto merge = [&] {
    merge_photographs(bracket, capture::Encoding::linear, {}, folder() / "out", silent_);
  };
  write("b.png", 0.07, 0);
  write("a.png", 0.02, 0);
  EXPECT_NO_THROW(merge());
  write("a.png", 0.02, 4);
  EXPECT_THAT(merge, ::testing::ThrowsMessage<InputError>(
                         ::testing::HasSubstr("a.png: its light fits an exposure time of 0.0012")));
}

TEST_F(Photographs, BoardsAloneGiveTheSessionsCamera) {
  const capture::Session session = capture::read_session(tiny_session());
  add(session, session.calibration.camera_boards, "board");
  const calib::CalibrationResult alone = calibrate_photographs(
      source(), session.calibration.board, std::nullopt, std::nullopt, folder() / "out", silent_);
  EXPECT_TRUE(fs::exists(folder() / "out" / "camera.yml"));
  EXPECT_FALSE(fs::exists(folder() / "out" / "projector.yml"));
  const auto together = calib::load_calibration(tiny_run() / "calibration");
  EXPECT_NEAR(alone.camera.lens.fx, together.camera.lens.fx, 0.02 * together.camera.lens.fx);
  EXPECT_NEAR(alone.camera.lens.fy, together.camera.lens.fy, 0.02 * together.camera.lens.fy);
  EXPECT_LT(alone.camera.rms_px, 0.3);
}

TEST_F(Photographs, WhatIsMissingIsNamed) {
  const capture::Session session = capture::read_session(tiny_session());
  add(session, {session.patterns.front().frames.front()}, "lit");
  EXPECT_THAT([&] { capture::bracket_session(source(), {}, silent_); },
              ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("at least two exposure")));
  add(session, session.calibration.camera_boards, "plane_0_board");
  EXPECT_THAT(
      [&] { capture::board_session(source(), session.calibration.board, {}, silent_); },
      ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("give the projector's size")));
  EXPECT_THAT(
      [&] {
        capture::board_session(source(), session.calibration.board, session.projector, silent_);
      },
      ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("plane_0_gray_0")));
}

TEST_F(Photographs, TheCommandsTakeAFolderWithoutASession) {
  const capture::Session session = capture::read_session(tiny_session());
  const capture::Board& board = session.calibration.board;
  add(session, session.calibration.camera_boards, "board");
  const std::string photographs = source().folder.string();
  const std::string size = std::to_string(board.columns) + "x" + std::to_string(board.rows);
  const auto done =
      kappamu("calibrate " + photographs + " -o " + (folder() / "camera").string() + " --board " +
              size + " --square " + std::to_string(board.square_mm) + " --json");
  EXPECT_EQ(done.exit_code, 0) << done.standard_error;
  EXPECT_THAT(done.standard_output, ::testing::HasSubstr("\"projector\":null"));
  const auto wrong = kappamu("calibrate " + photographs + " -o " + (folder() / "wrong").string() +
                             " --board 9by6 --square 5");
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.standard_error, ::testing::HasSubstr("columns x rows"));
}

}  // namespace
}  // namespace kappamu::pipeline
