// `kappamu verify`, and that commands refuse or make again what was changed between them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/read_file.h"
#include "io/volume/volume_file.h"
#include "tests/app/process.h"
#include "tests/app/tiny_session.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

/// The middle byte of `file` becomes another, size and time kept; a hard link is parted from the
/// others.
void change(const fs::path& file) {
  const fs::file_time_type time = fs::last_write_time(file);
  std::string text = io::read_text(file);
  text[text.size() / 2] ^= 1;
  io::write_text_atomically(file, text);
  fs::last_write_time(file, time);
}

class VerifyCommand : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    TemporaryFolderTest::SetUp();
    // Hard links need one file system: beside the shared session, not in the system's /tmp.
    beside_ = fs::path(KAPPAMU_TEST_FOLDER) / ("verify-" + folder().filename().string());
    fs::create_directories(beside_);
    linked_session(beside_ / "session");
  }
  void TearDown() override {
    fs::remove_all(beside_);
    TemporaryFolderTest::TearDown();
  }
  std::string at(const std::string& name) const { return (beside_ / name).string(); }
  fs::path beside_;
};

TEST_F(VerifyCommand, ChangesBetweenStagesAreRefusedOrMadeAgain) {
  const std::string arguments = at("session") + " -o " + at("run");
  ASSERT_EQ(kappamu("calibrate " + arguments).exit_code, 0);
  const ProcessResult whole = kappamu("verify " + at("run") + " --json");
  EXPECT_EQ(whole.exit_code, 0) << whole.standard_error;
  const json summary = json::parse(last_line(whole.standard_output));
  EXPECT_TRUE(summary["whole"].get<bool>());
  EXPECT_TRUE(summary["findings"].empty()) << summary;
  EXPECT_GT(summary["files"].get<int>(), 20) << "photographs too";

  const std::string camera = io::read_text(at("run/calibration/camera.yml"));
  change(at("run/calibration/camera.yml"));
  const ProcessResult damaged = kappamu("verify " + at("run"));
  expect_one_sentence(damaged, "1 of its files or inputs");
  EXPECT_THAT(damaged.standard_output, HasSubstr("changed        calibration/camera.yml"));
  expect_one_sentence(kappamu("merge " + arguments), "camera.yml was changed");
  const ProcessResult again = kappamu("calibrate " + arguments);
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.standard_error, HasSubstr("camera.yml was changed"));
  EXPECT_EQ(io::read_text(at("run/calibration/camera.yml")), camera);
  EXPECT_EQ(kappamu("verify " + at("run")).exit_code, 0);

  // A photograph at equal size and time.
  const json session = json::parse(io::read_text(at("session/session.json")));
  const auto frame = session["patterns"][0]["frames"][0]["file"].get<std::string>();
  change(beside_ / "session" / frame);
  const ProcessResult input = kappamu("verify " + at("run"));
  EXPECT_EQ(input.exit_code, 1);
  EXPECT_THAT(input.standard_output, HasSubstr("input changed  " + at("session/" + frame)));
}

TEST_F(VerifyCommand, ChangedResultsAreNeitherRenderedScoredNorReported) {
  io::VolumeSet set;
  set.channels = {"R"};
  const GridShape shape{2, 2, 1, 0.5};
  set.media.push_back({Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)});
  io::write_vdb(beside_ / "volume.vdb", set);
  const std::string made = at("made");
  ASSERT_EQ(kappamu("export " + at("volume.vdb") + " --format vdb -o " + made).exit_code, 0);
  ASSERT_EQ(kappamu("render --new-scene " + made + " -o " + at("scene.json")).exit_code, 0);
  change(at("made/volume.vdb"));
  for (const std::string& command :
       {"render " + at("scene.json") + " -o " + at("picture"),
        "score " + made + " --truth " + (tiny_session() / ".." / "truth").string(),
        "report " + made}) {
    expect_one_sentence(kappamu(command), "volume.vdb was changed");
  }
}

TEST_F(VerifyCommand, RecordsOfOtherVersionsAreNamed) {
  fs::create_directories(at("run"));
  for (const char* record :
       {R"({"format": "kappamu-run", "version": 1, "input": "s", "stages": {}})",
        R"({"format": "kappamu-run", "version": 2})"}) {
    io::write_text_atomically(at("run/run.json"), record);
    expect_one_sentence(kappamu("verify " + at("run")), "another version of kappamu");
    expect_one_sentence(kappamu("calibrate " + at("session") + " -o " + at("run")),
                        "another version of kappamu");
  }
}

TEST_F(VerifyCommand, AFolderWithoutRecordIsNamed) {
  expect_one_sentence(kappamu("verify " + at("session")), "neither run.json nor");
  expect_one_sentence(kappamu("verify " + at("nowhere")), "no such folder");
}

}  // namespace
}  // namespace kappamu::app
