// Reading and writing session.json. That reader and schema agree is tested in
// session_schema_test.cpp on the same table of bad documents.
#include "capture/session/session.h"
#include "capture/session/session_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/error.h"
#include "tests/capture/session/bad_sessions.h"
#include "tests/capture/session_files.h"
#include "tests/sentence.h"

namespace kappamu::capture {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

TEST(Session, TheDocumentedExampleIsReadWithEveryValueInItsPlace) {
  const OwnFolder folder;
  write_text(folder.path() / "session.json", documented_session_text());
  const Session session = read_session(folder.path());
  EXPECT_EQ(session.folder, folder.path());
  EXPECT_EQ(session.setup, Setup::back_lit);
  EXPECT_EQ(session.channels, (std::vector<std::string>{"R", "G", "B"}));
  EXPECT_EQ(session.sample.grid, (std::array<int, 3>{40, 32, 12}));
  EXPECT_EQ(session.sample.voxel_mm, 0.5);
  EXPECT_EQ(session.sample.lit_face, Face::z_minus);
  EXPECT_EQ(session.sample.seen_face, Face::z_plus);
  EXPECT_EQ(session.camera.bit_depth, 12);
  EXPECT_EQ(session.camera.encoding, Encoding::response);
  EXPECT_EQ(session.camera.electrons_full_scale, 20000.0);
  EXPECT_EQ(session.camera.read_noise_electrons, 5.0);
  EXPECT_EQ(session.projector.width, 1024);
  EXPECT_EQ(session.calibration_station, "front");
  EXPECT_EQ(session.pattern_station, "back");
  ASSERT_EQ(session.patterns.size(), 1U);
  EXPECT_EQ(session.patterns[0].id, "fit_00");
  ASSERT_EQ(session.patterns[0].frames.size(), 2U);
  EXPECT_EQ(session.patterns[0].frames[1].exposure_s, 0.2);
  EXPECT_EQ(session.calibration.board.square_mm, 4.0);
  EXPECT_EQ(session.calibration.projected_board->origin_px, (std::array<double, 2>{500.0, 200.0}));
  EXPECT_EQ(session.calibration.projector_planes[0].projected->file,
            "calibration/plane_00_projected.png");
  EXPECT_EQ(session.calibration.sample_views[1].face, Face::z_plus);
  ASSERT_TRUE(session.calibration.white_target.has_value());
  EXPECT_EQ(session.calibration.white_target->reflectance, 0.99);
  EXPECT_EQ(session.calibration.white_target->black_frames.size(), 1U);
  EXPECT_TRUE(session.calibration.colour_chart.has_value());
}

TEST(Session, WritingAndReadingGivesTheSameFileAgain) {
  const OwnFolder folder;
  write_text(folder.path() / "session.json", documented_session_text());
  Session session = read_session(folder.path());
  session.calibration.sample_views[0].corners_px = {{{1.25, 2}, {600, 3}, {610, 400}, {0.1, 399}}};
  session.calibration.colour_chart->corners_px = {{{1, 2}, {600, 3}, {610, 400}, {0.1, 399}}};
  session.patterns[0].frames[0].exposure_s = 1.0 / 30.0;
  session.smooth_error = SmoothError{1e-3, 3e-3};
  session.calibration.lens = LensFile{"calibration/camera.yml", false};
  write_session(session);
  const std::string first = read_text(folder.path() / "session.json");
  const Session again = read_session(folder.path());
  write_session(again);
  EXPECT_EQ(read_text(folder.path() / "session.json"), first);
  EXPECT_EQ(again.patterns[0].frames[0].exposure_s, 1.0 / 30.0);
  EXPECT_EQ(again.smooth_error, session.smooth_error);
  EXPECT_EQ(again.calibration.lens->file, "calibration/camera.yml");
  EXPECT_FALSE(again.calibration.lens->held);
  EXPECT_THAT(named_files(again), testing::Contains("calibration/camera.yml"));
  EXPECT_EQ(again.calibration.sample_views[0].corners_px,
            session.calibration.sample_views[0].corners_px);
}

TEST(Session, OptionalPartsMayBeLeftOut) {
  const OwnFolder folder;
  for (const EditedSession& good : good_sessions()) {
    write_text(folder.path() / "session.json", good.text);
    EXPECT_NO_THROW(read_session(folder.path())) << good.name;
  }
}

TEST(Session, EveryMistakeIsToldInOneSentenceNamingFileFieldAndFix) {
  const OwnFolder folder;
  const std::string file = (folder.path() / "session.json").string();
  for (const BadSession& bad : bad_sessions()) {
    write_text(file, bad.text);
    const std::string sentence = sentence_of([&] { read_session(folder.path()); });
    EXPECT_THAT(sentence, AllOf(StartsWith(file + ": " + bad.field), HasSubstr(bad.says),
                                EndsWith("."), testing::Not(HasSubstr("\n"))))
        << bad.name;
  }
}

TEST(Session, AWrongUnitIsNamedWithTheRightOne) {
  const OwnFolder folder;
  std::string text = documented_session_text();
  text.replace(text.find("\"mm\""), 4, "\"cm\"");
  write_text(folder.path() / "session.json", text);
  EXPECT_THAT(sentence_of([&] { read_session(folder.path()); }),
              HasSubstr("session.json: units.length is 'cm'; kappamu sessions are in 'mm'"));
}

TEST(Session, AMissingFolderOrFileIsNamed) {
  const OwnFolder folder;
  EXPECT_THAT(sentence_of([&] { read_session(folder.path() / "nowhere"); }),
              HasSubstr("nowhere: no such folder"));
  EXPECT_THAT(sentence_of([&] { read_session(folder.path()); }),
              HasSubstr("session.json: no such file"));
  std::filesystem::create_directory(folder.path() / "session.json");
  EXPECT_THAT(sentence_of([&] { read_session(folder.path()); }),
              HasSubstr("session.json: no such file"));
}

TEST(Session, AnInvalidSessionIsNotWritten) {
  const OwnFolder folder;
  write_text(folder.path() / "session.json", documented_session_text());
  Session session = read_session(folder.path());
  std::filesystem::remove(folder.path() / "session.json");
  session.patterns[0].frames[1].exposure_s = -1.0;
  EXPECT_THAT(sentence_of([&] { write_session(session); }),
              HasSubstr("patterns[0].frames[1].exposure_s"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "session.json"));
}

// Whatever is done to the file's bytes, the reader returns a session or throws InputError: any
// other exception or a crash fails the test. Sanitizer builds run the same case.
TEST(Session, RandomDamageNeverCausesAnythingButInputError) {
  const OwnFolder folder;
  const std::string original = documented_session_text();
  const std::string alphabet = "{}[]\",:0123456789-.eE \\ntfu\xff\x80";
  std::mt19937 random(20240607);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  int refused = 0;
  constexpr int rounds = 1500;
  for (int round = 0; round < rounds; ++round) {
    std::string text = original;
    const std::size_t edits = 1 + below(4);
    for (std::size_t edit = 0; edit < edits && !text.empty(); ++edit) {
      const std::size_t at = below(text.size());
      switch (below(4)) {
        case 0:
          text[at] = alphabet[below(alphabet.size())];
          break;
        case 1:
          text.erase(at, 1 + below(8));
          break;
        case 2:
          text.insert(at, 1, alphabet[below(alphabet.size())]);
          break;
        default:
          text.insert(at, text.substr(below(text.size()), below(40)));
      }
    }
    if (below(50) == 0) text.resize(below(text.size()));
    write_text(folder.path() / "session.json", text);
    try {
      read_session(folder.path());
    } catch (const InputError&) {
      ++refused;
    }
  }
  // Most single edits break a field; a reader that lets half of them pass is not strict.
  EXPECT_GT(refused, rounds / 2);
}

}  // namespace
}  // namespace kappamu::capture
