// One stage of the work on photographs alone gives what the whole session's stage gives.
#include "pipeline/stages/photographs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "calib/calibration_file.h"
#include "capture/session/session.h"
#include "core/error.h"
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

  ASSERT_EQ(
      kappamu("merge " + tiny_session().string() + " -o " + (folder() / "run").string()).exit_code,
      0);
  const capture::HdrImage alone = read_hdr(folder() / "out" / "radiance.exr", session.channels);
  const capture::HdrImage together =
      read_hdr(folder() / "run" / "hdr" / (pattern.id + ".exr"), session.channels);
  double difference = 0.0, norm = 0.0;
  for (std::size_t i = 0; i < alone.radiance.size(); ++i) {
    if (alone.flags.values()[i] != 0 || together.flags.values()[i] != 0) continue;
    const double a = alone.radiance.values()[i], b = together.radiance.values()[i];
    difference += (a - b) * (a - b);
    norm += b * b;
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

TEST_F(Photographs, BoardsAloneGiveTheSessionsCamera) {
  const capture::Session session = capture::read_session(tiny_session());
  add(session, session.calibration.camera_boards, "board");
  const calib::CalibrationResult alone = calibrate_photographs(
      source(), session.calibration.board, std::nullopt, folder() / "out", silent_);
  EXPECT_TRUE(fs::exists(folder() / "out" / "camera.yml"));
  EXPECT_FALSE(fs::exists(folder() / "out" / "projector.yml"));
  ASSERT_EQ(kappamu("calibrate " + tiny_session().string() + " -o " + (folder() / "run").string())
                .exit_code,
            0);
  const auto together = calib::load_calibration(folder() / "run" / "calibration");
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
  EXPECT_THAT([&] { capture::board_session(source(), session.calibration.board, {}, silent_); },
              ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("--projector")));
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
