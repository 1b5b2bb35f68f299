// What `kappamu run` relies on to resume: stages are done once, go on after an interruption with
// the same inputs, and start afresh with others. The whole command, killed at random moments, is
// in run_test.cpp.
#include "pipeline/run_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/error.h"
#include "io/read_file.h"
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
  RunFolder open(const std::string& input_fingerprint = "one", Results results = Results::kept) {
    return {folder() / "run", RunRecord::InputKind::session, folder() / "session",
            input_fingerprint, results};
  }
  /// Work that leaves its output and counts.
  RunFolder::Work work(const std::string& content = "complete") {
    return [this, content](const fs::path& output, Progress&) {
      ++calls_;
      std::ofstream(output / "out") << content;
    };
  }
  static void interrupted(const fs::path& output, Progress&) {
    std::ofstream(output / "out") << "partial";
    throw InputError("interrupted");
  }
  std::string out() const { return io::read_text(folder() / "run" / "out"); }
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
  EXPECT_TRUE(open("one", Results::replaced).run({"fit", "other key", {"out"}}, silent_, work()));
  EXPECT_EQ(calls_, 4);
}

TEST_F(RunFolderTest, InterruptedStageFindsItsPartialOutputs) {
  const RunFolder::Stage stage{"fit", "key", {"out"}, Interrupted::continued};
  EXPECT_THROW(open().run(stage, silent_, interrupted), InputError);
  bool found = false;
  open().run(stage, silent_,
             [&](const fs::path& output, Progress&) { found = fs::exists(output / "out"); });
  EXPECT_TRUE(found);
}

TEST_F(RunFolderTest, PartialOutputsOfOtherInputsAreNotFound) {
  EXPECT_THROW(open().run({"fit", "key", {"out"}, Interrupted::continued}, silent_, interrupted),
               InputError);
  bool found = true;
  open().run({"fit", "other key", {"out"}, Interrupted::continued}, silent_,
             [&](const fs::path& output, Progress&) { found = fs::exists(output / "out"); });
  EXPECT_FALSE(found);
}

TEST_F(RunFolderTest, FormerOutputsStayUntilTheNewAreComplete) {
  open().run({"fit", "key", {"out", "more"}}, silent_, [&](const fs::path& output, Progress&) {
    fs::create_directories(output / "more");
    std::ofstream(output / "out") << "first";
    std::ofstream(output / "more" / "a") << "first";
  });
  EXPECT_THROW(open().run({"fit", "other key", {"out", "more"}}, silent_, interrupted), InputError);
  EXPECT_EQ(out(), "first");
  EXPECT_FALSE(fs::exists(folder() / "run" / "fit.partial")) << "nothing to go on with";
  open().run({"fit", "other key", {"out", "more"}}, silent_, work("second"));
  EXPECT_EQ(out(), "second");
  EXPECT_FALSE(fs::exists(folder() / "run" / "more")) << "not made again, so removed";
}

// A file of someone else is refused before any work, wherever a stage writes.
TEST_F(RunFolderTest, FileOfSomeoneElseIsRefusedAndStays) {
  fs::create_directories(folder() / "run" / "hdr" / "deep");
  std::ofstream(folder() / "run" / "hdr" / "deep" / "precious.txt") << "mine";
  const auto attempt = [&] { open().run({"merge", "key", {"out", "hdr"}}, silent_, work()); };
  EXPECT_THAT(sentence_of(attempt), HasSubstr("hdr/deep/precious.txt: is in the way"));
  fs::remove_all(folder() / "run" / "hdr");
  for (const char* name : {"out", "merge.partial"}) {
    fs::create_directories(folder() / "elsewhere");
    fs::create_directory_symlink(folder() / "elsewhere", folder() / "run" / name);
    EXPECT_THAT(sentence_of(attempt), HasSubstr(std::string(name) + ": is in the way"));
    fs::remove(folder() / "run" / name);
    std::ofstream(folder() / "run" / name) << "mine";
    EXPECT_THAT(sentence_of(attempt), HasSubstr(std::string(name) + ": is in the way"));
    EXPECT_EQ(io::read_text(folder() / "run" / name), "mine");
    fs::remove(folder() / "run" / name);
  }
  EXPECT_EQ(calls_, 0);
  // What turns up while the stage works is left alone too; the results wait beside it.
  const auto late = [&](const fs::path& output, Progress&) {
    std::ofstream(output / "out") << "complete";
    std::ofstream(folder() / "run" / "out") << "mine";
  };
  EXPECT_THAT(sentence_of([&] {
                open().run({"merge", "key", {"out"}, Interrupted::continued}, silent_, late);
              }),
              HasSubstr("out: is in the way"));
  EXPECT_EQ(out(), "mine");
}

// Every state that a kill can leave between the steps of the move ends in the new files.
TEST_F(RunFolderTest, MoveCutShortIsFinished) {
  const auto two_files = [](const std::string& content) {
    return [content](const fs::path& output, Progress&) {
      std::ofstream(output / "a") << content;
      std::ofstream(output / "b") << content;
    };
  };
  const fs::path run = folder() / "run";
  for (const int moved : {0, 1, 2}) {
    fs::remove_all(run);
    open().run({"fit", "key", {"a", "b", "c"}}, silent_, [&](const fs::path& output, Progress& p) {
      two_files("old")(output, p);
      std::ofstream(output / "c") << "old";
    });
    // The record as it stands while files move.
    RunRecord record = *read_run_record(run);
    fs::create_directories(run / "fit.partial");
    two_files("new")(run / "fit.partial", silent_);
    StageRecord& stage = record.stages.at("fit");
    stage.status = StageStatus::moving;
    stage.key = "new key";
    stage.next = describe_files(run / "fit.partial", {"a", "b"});
    write_run_record(record, run);
    for (int i = 0; i < moved; ++i)
      fs::rename(run / "fit.partial" / (i == 0 ? "a" : "b"), run / (i == 0 ? "a" : "b"));

    EXPECT_EQ(open().done_key("fit"), "new key");
    EXPECT_EQ(io::read_text(run / "a"), "new");
    EXPECT_EQ(io::read_text(run / "b"), "new");
    EXPECT_FALSE(fs::exists(run / "c"));
    EXPECT_FALSE(fs::exists(run / "fit.partial"));
  }
}

TEST_F(RunFolderTest, RecordThatLeavesTheFolderIsRefused) {
  open().run({"fit", "key", {"out"}}, silent_, work());
  const fs::path file = folder() / "run" / "run.json";
  std::string text = io::read_text(file);
  text.replace(text.find("\"path\": \"out\""), 13, "\"path\": \"../precious.txt\"");
  std::ofstream(folder() / "precious.txt") << "mine";
  std::ofstream(file) << text;
  EXPECT_THAT(sentence_of([&] { open("one", Results::replaced); }), HasSubstr("../precious.txt"));
  EXPECT_TRUE(fs::exists(folder() / "precious.txt"));
}

TEST_F(RunFolderTest, TemporariesOfTheRecordGoAndWhatLooksLikeOneStays) {
  fs::create_directories(folder() / "run");
  std::ofstream(folder() / "run" / ".run.partial-999999999-0.json") << "";
  std::ofstream(folder() / "run" / ".run.partial-999999999-1.json") << "{\"format\": \"mine\"}";
  std::ofstream(folder() / "run" / ".notes.partial-999999999-0.txt") << "mine";
  open();
  EXPECT_FALSE(fs::exists(folder() / "run" / ".run.partial-999999999-0.json"));
  EXPECT_TRUE(fs::exists(folder() / "run" / ".run.partial-999999999-1.json"));
  EXPECT_TRUE(fs::exists(folder() / "run" / ".notes.partial-999999999-0.txt"));
}

TEST_F(RunFolderTest, WarningsAreKeptOnceEach) {
  {
    RunFolder run = open();
    run.run({"fit", "key", {}}, silent_, [](const fs::path&, Progress& progress) {
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
  EXPECT_THAT(sentence, HasSubstr("(out, force)"));
  EXPECT_NO_THROW(open("two", Results::replaced));
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
  const fs::file_time_type time = fs::last_write_time(file);
  std::ofstream(file) << "two";
  const std::string two = now();
  std::ofstream(file) << "one";
  fs::last_write_time(file, time);
  EXPECT_NE(two, now()) << "equal in size";
}

}  // namespace
}  // namespace kappamu::pipeline
