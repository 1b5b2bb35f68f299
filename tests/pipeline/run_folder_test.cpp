// What `kappamu run` relies on to resume: stages are done once, go on after an interruption with
// the same inputs, and start afresh with others. The whole command, killed at random moments, is
// in run_test.cpp.
#include "pipeline/run_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/error.h"
#include "pipeline/records/fingerprint.h"
#include "tests/app/process.h"
#include "tests/sentence.h"

namespace kappamu::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

class RunFolderTest : public TemporaryFolderTest {
 protected:
  RunFolder open(const std::string& input_fingerprint = "one", bool force = false) {
    return {folder() / "run", RunRecord::InputKind::session, folder() / "session",
            input_fingerprint, force};
  }
  /// Work that leaves its output and counts.
  std::function<void(Progress&)> work() {
    return [this](Progress&) {
      ++calls_;
      std::ofstream(folder() / "run" / "out") << "complete";
    };
  }
  int calls_ = 0;
  Progress silent_;
};

TEST_F(RunFolderTest, DoneStageIsNotRepeated) {
  EXPECT_TRUE(open().run({"fit", "key", {"out"}}, silent_, work()));
  EXPECT_FALSE(open().run({"fit", "key", {"out"}}, silent_, work()));
  EXPECT_EQ(calls_, 1);
}

TEST_F(RunFolderTest, OtherKeyOrLostOutputOrForceRepeats) {
  open().run({"fit", "key", {"out"}}, silent_, work());
  EXPECT_TRUE(open().run({"fit", "other key", {"out"}}, silent_, work()));
  fs::remove(folder() / "run" / "out");
  EXPECT_TRUE(open().run({"fit", "other key", {"out"}}, silent_, work()));
  EXPECT_TRUE(open("one", true).run({"fit", "other key", {"out"}}, silent_, work()));
  EXPECT_EQ(calls_, 4);
}

TEST_F(RunFolderTest, InterruptedStageFindsItsPartialOutputs) {
  const auto interrupted = [this](Progress&) {
    std::ofstream(folder() / "run" / "out") << "partial";
    throw InputError("interrupted");
  };
  EXPECT_THROW(open().run({"fit", "key", {"out"}}, silent_, interrupted), InputError);
  bool found = false;
  open().run({"fit", "key", {"out"}}, silent_,
             [&](Progress&) { found = fs::exists(folder() / "run" / "out"); });
  EXPECT_TRUE(found);
}

TEST_F(RunFolderTest, PartialOutputsOfOtherInputsAreRemoved) {
  const auto interrupted = [this](Progress&) {
    std::ofstream(folder() / "run" / "out") << "partial";
    throw InputError("interrupted");
  };
  EXPECT_THROW(open().run({"fit", "key", {"out"}}, silent_, interrupted), InputError);
  bool found = true;
  open().run({"fit", "other key", {"out"}}, silent_,
             [&](Progress&) { found = fs::exists(folder() / "run" / "out"); });
  EXPECT_FALSE(found);
}

TEST_F(RunFolderTest, WarningsAreKeptOnceEach) {
  {
    RunFolder run = open();
    run.run({"fit", "key", {}}, silent_, [](Progress& progress) {
      progress.warn("too thin");
      progress.warn("too thin");
    });
  }
  const auto record = read_run_record(folder() / "run");
  ASSERT_TRUE(record.has_value());
  EXPECT_THAT(record->stages.at("fit").warnings, ElementsAre("too thin"));
}

TEST_F(RunFolderTest, AnotherInputIsRefusedUnlessForced) {
  open("one").run({"fit", "key", {"out"}}, silent_, work());
  const std::string sentence = sentence_of([&] { open("two"); });
  EXPECT_THAT(sentence, HasSubstr("holds a run of another input"));
  EXPECT_THAT(sentence, HasSubstr("--force"));
  EXPECT_NO_THROW(open("two", true));
}

TEST_F(RunFolderTest, SecondProcessIsKeptOut) {
  const RunFolder first = open();
  const std::string sentence = sentence_of([&] { open(); });
  EXPECT_THAT(sentence, HasSubstr("another kappamu is working"));
}

TEST_F(RunFolderTest, DamagedRecordIsNamed) {
  fs::create_directories(folder() / "run");
  std::ofstream(folder() / "run" / "run.json") << "{\"format\": \"kappamu-run\", ";
  const std::string sentence = sentence_of([&] { open(); });
  EXPECT_THAT(sentence, HasSubstr("run.json"));
}

TEST(FingerprintTest, BoundariesBetweenPiecesCount) {
  EXPECT_NE(Fingerprint().add("ab").add("c").text(), Fingerprint().add("a").add("bc").text());
  EXPECT_EQ(Fingerprint().add("ab").text(), Fingerprint().add("ab").text());
}

TEST_F(RunFolderTest, FileFingerprintSeesEditsAndLoss) {
  const fs::path file = folder() / "frame.png";
  const auto now = [&] { return Fingerprint().add_file(file).text(); };
  const std::string missing = now();
  std::ofstream(file) << "one";
  const std::string one = now();
  EXPECT_NE(one, missing);
  EXPECT_EQ(one, now());
  std::ofstream(file) << "longer";
  EXPECT_NE(one, now());
}

}  // namespace
}  // namespace kappamu::pipeline
