// What an operator sees when a session is wrong: exit code 1 and one sentence naming what to mend.
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "capture/session/session.h"
#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "io/read_file.h"
#include "tests/app/process.h"
#include "tests/app/tiny_session.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class BadSession : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    TemporaryFolderTest::SetUp();
    // Hard links need one file system: beside the shared session, not in the system's /tmp.
    beside_ = fs::path(KAPPAMU_TEST_FOLDER) / ("bad-" + folder().filename().string());
    session_ = linked_session(beside_);
  }
  void TearDown() override {
    fs::remove_all(beside_);
    TemporaryFolderTest::TearDown();
  }

  void edit(const std::function<void(json&)>& change) const {
    json document = json::parse(io::read_text(session_ / "session.json"));
    change(document);
    io::write_text_atomically(session_ / "session.json", document.dump());
  }
  capture::Session read() const { return capture::read_session(session_); }

  /// Replaces a frame by one of constant code value.
  void flatten(const std::string& file, std::uint16_t code, int width, int height) const {
    const capture::Session session = read();
    io::write_code_image(
        session_ / file,
        Image<std::uint16_t>(width, height, static_cast<int>(session.channels.size()), code),
        session.camera.bit_depth);
  }
  ProcessResult run(const std::string& command) const {
    return kappamu(command + " " + session_.string() + " -o " + (folder() / "run").string());
  }

  fs::path session_;

 private:
  fs::path beside_;
};

TEST_F(BadSession, MissingFrame) {
  const std::string file = read().patterns.front().frames.front().file;
  fs::remove(session_ / file);
  expect_one_sentence(run("merge"), file);
}

TEST_F(BadSession, TruncatedFrame) {
  const std::string file = read().patterns.front().frames.front().file;
  const std::string bytes = io::read_text(session_ / file);
  io::write_text_atomically(session_ / file, bytes.substr(0, bytes.size() / 2));
  expect_one_sentence(run("merge"), file);
}

TEST_F(BadSession, WrongSizedFrame) {
  const capture::Session session = read();
  const std::string file = session.patterns.front().frames.front().file;
  flatten(file, 100, session.camera.width / 2, session.camera.height);
  expect_one_sentence(run("merge"), file);
}

TEST_F(BadSession, ZeroExposure) {
  edit([](json& s) { s["patterns"][0]["frames"][0]["exposure_s"] = 0.0; });
  expect_one_sentence(run("run"), "exposure_s");
}

TEST_F(BadSession, EqualExposures) {
  edit([](json& s) {
    json& frames = s["patterns"][0]["frames"];
    frames[1]["exposure_s"] = frames[0]["exposure_s"];
  });
  expect_one_sentence(run("run"), "exposure");
}

TEST_F(BadSession, AllFramesSaturated) {
  const capture::Session session = read();
  const auto full = static_cast<std::uint16_t>((1 << session.camera.bit_depth) - 1);
  const capture::Pattern& pattern = session.patterns.front();
  for (const capture::Frame& frame : pattern.frames)
    flatten(frame.file, full, session.camera.width, session.camera.height);
  const ProcessResult result = run("merge");
  expect_one_sentence(result, pattern.id);
  expect_one_sentence(result, "saturated");
}

TEST_F(BadSession, UnknownField) {
  edit([](json& s) { s["camera"]["widht"] = 640; });
  expect_one_sentence(run("run"), "widht");
}

TEST_F(BadSession, WrongUnit) {
  edit([](json& s) { s["units"]["length"] = "cm"; });
  expect_one_sentence(run("run"), "units.length");
}

TEST_F(BadSession, BoardNotFound) {
  edit([](json& s) {  // the fewest that are taken
    for (const char* list : {"camera_boards", "projector_planes"}) {
      json& shots = s["calibration"][list];
      shots.erase(shots.begin() + 3, shots.end());
    }
  });
  const capture::Session session = read();
  std::vector<capture::Frame> boards = session.calibration.camera_boards;
  for (const auto& plane : session.calibration.projector_planes) boards.push_back(plane.board);
  for (const capture::Frame& frame : boards)
    flatten(frame.file, 1000, session.camera.width, session.camera.height);
  expect_one_sentence(run("calibrate"), "board");
}

}  // namespace
}  // namespace kappamu::app
