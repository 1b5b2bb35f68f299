// What kappamu notices of files that changed behind its back, whatever their size and time.
#include "pipeline/verify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/error.h"
#include "io/read_file.h"
#include "pipeline/run_folder.h"
#include "tests/app/process.h"
#include "tests/sentence.h"

namespace kappamu::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

/// Another byte of `file`, size and time kept.
void change_byte(const fs::path& file, std::size_t at, unsigned char flipped = 1) {
  const fs::file_time_type time = fs::last_write_time(file);
  std::string text = io::read_text(file);
  text.at(at) = static_cast<char>(static_cast<unsigned char>(text.at(at)) ^ flipped);
  std::ofstream(file, std::ios::binary) << text;
  fs::last_write_time(file, time);
}

class Verify : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    TemporaryFolderTest::SetUp();
    fs::create_directories(folder() / "session");
    std::ofstream(folder() / "session" / "frame.png") << "light";
    RunFolder run = open();
    run.set_inputs(describe_files(folder() / "session", {"frame.png"}));
    run.run(fit_, silent_, [&](const fs::path& output, Progress&) {
      fs::create_directories(output / "fit");
      std::ofstream(output / "fit" / "kappa.npy") << "kappa";
      std::ofstream(output / "fit" / "mu.npy") << "mu";
    });
  }
  RunFolder open() {
    return {folder() / "run", RunRecord::InputKind::session, folder() / "session", "one",
            Results::kept};
  }
  fs::path run(const std::string& file) const { return folder() / "run" / file; }
  /// "what name" of every finding.
  std::vector<std::string> findings() {
    std::vector<std::string> lines;
    for (const Finding& f : verify_folder(folder() / "run", silent_).findings)
      lines.push_back(to_string(f.what) + " " + f.name);
    return lines;
  }
  const RunFolder::Stage fit_{"fit", "key", {"fit"}};
  Progress silent_;
};

TEST_F(Verify, AWholeRunHasNoFindings) {
  EXPECT_THAT(findings(), IsEmpty());
  EXPECT_EQ(verify_folder(folder() / "run", silent_).files, 3U);
  EXPECT_NO_THROW(require_as_written(run("fit")));
  EXPECT_NO_THROW(require_as_written(folder() / "session"));
  EXPECT_THAT(sentence_of([&] { verify_folder(folder() / "session", silent_); }),
              HasSubstr("neither run.json nor kappamu-files.json"));
}

TEST_F(Verify, EveryKindOfDamageIsNamed) {
  change_byte(run("fit/mu.npy"), 1);
  fs::remove(run("fit/kappa.npy"));
  change_byte(folder() / "session" / "frame.png", 0);
  std::ofstream(run("notes.txt")) << "mine";
  EXPECT_THAT(findings(),
              UnorderedElementsAre(
                  "changed fit/mu.npy", "missing fit/kappa.npy", "foreign notes.txt",
                  "input changed " + fs::canonical(folder() / "session" / "frame.png").string()));
  EXPECT_THAT(sentence_of([&] { require_as_written(run("fit")); }),
              HasSubstr("kappa.npy is missing"));
  EXPECT_THAT(sentence_of([&] { require_as_written(run("fit/mu.npy")); }),
              HasSubstr("mu.npy was changed after kappamu fit wrote it"));
  fs::remove_all(folder() / "session");
  EXPECT_THAT(findings(), testing::Contains(HasSubstr("no input ")));
}

TEST_F(Verify, ADamagedStageIsDoneAgain) {
  change_byte(run("fit/mu.npy"), 0);
  EXPECT_THAT(sentence_of([&] { open().require_whole("fit"); }), HasSubstr("mu.npy was changed"));
  EXPECT_FALSE(open().done_key("fit").has_value());
  RunFolder again = open();
  EXPECT_TRUE(again.run(fit_, silent_, [&](const fs::path& output, Progress&) {
    fs::create_directories(output / "fit");
    std::ofstream(output / "fit" / "mu.npy") << "mu";
  }));
  EXPECT_EQ(io::read_text(run("fit/mu.npy")), "mu");
  EXPECT_EQ(again.done_key("fit"), "key");
}

TEST_F(Verify, UnfinishedStagesAreNamed) {
  EXPECT_THROW(open().run({"merge", "key", {"hdr"}, Interrupted::continued}, silent_,
                          [](const fs::path& output, Progress&) {
                            std::ofstream(output / "hdr") << "half";
                            throw InputError("killed");
                          }),
               InputError);
  EXPECT_THAT(findings(), UnorderedElementsAre("unfinished merge"));
}

// Every bit of every file: noticed, or the record says the same in other spaces.
TEST_F(Verify, EveryFlippedBitIsNoticed) {
  const RunRecord record = *read_run_record(folder() / "run");
  int noticed = 0;
  int spaces = 0;
  for (const char* file : {"run.json", "fit/kappa.npy", "fit/mu.npy"}) {
    const std::size_t size = fs::file_size(run(file));
    for (std::size_t bit = 0; bit < 8 * size; bit += std::string(file) == "run.json" ? 5 : 1) {
      const auto mask = static_cast<unsigned char>(1U << bit % 8);
      change_byte(run(file), bit / 8, mask);
      try {
        if (findings().empty()) {
          ASSERT_STREQ(file, "run.json") << bit;
          EXPECT_EQ(read_run_record(folder() / "run")->stages.at("fit").key,
                    record.stages.at("fit").key);
          ++spaces;
        } else {
          ++noticed;
        }
      } catch (const InputError&) {
        ++noticed;
      }
      change_byte(run(file), bit / 8, mask);
    }
  }
  EXPECT_GT(noticed, 500);
  EXPECT_LT(spaces, noticed / 5) << "only where JSON does not care";
  EXPECT_THAT(findings(), IsEmpty());
}

}  // namespace
}  // namespace kappamu::pipeline
