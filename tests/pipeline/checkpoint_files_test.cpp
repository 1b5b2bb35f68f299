// Two checkpoints on the disk: what is of no use never takes the place of what may be.
#include "pipeline/stages/checkpoint_files.h"

#include <gtest/gtest.h>

#include <string>

#include "io/atomic_file.h"
#include "tests/app/process.h"

namespace kappamu::pipeline {
namespace {

namespace fs = std::filesystem;

class CheckpointFilesTest : public TemporaryFolderTest {
 protected:
  CheckpointFiles files() const { return {folder() / "checkpoint_R.bin", 100}; }
  void save(const std::string& text) const { files().save(std::as_bytes(std::span(text))); }
  /// What load() gives, call by call.
  static std::vector<std::string> all(CheckpointFiles files) {
    std::vector<std::string> found;
    while (const auto bytes = files.load()) {
      found.emplace_back(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    }
    return found;
  }
};
using Texts = std::vector<std::string>;

TEST_F(CheckpointFilesTest, TheNewestComesFirstThenTheOneBefore) {
  EXPECT_EQ(all(files()), Texts{});
  save("one");
  save("two");
  save("three");
  EXPECT_EQ(all(files()), (Texts{"three", "two"}));
}

TEST_F(CheckpointFilesTest, OneOfNoUseIsRemovedAndTheOneBeforeKeptUntilThereAreTwoAgain) {
  save("good");
  save("damaged");
  CheckpointFiles resumed = files();
  resumed.load();
  resumed.load();  // the first was of no use
  EXPECT_EQ(all(files()), Texts{"good"});
  save("good");
  CheckpointFiles once_more = files();
  once_more.load();
  save("next");
  EXPECT_EQ(all(files()), (Texts{"next", "good"}));
}

TEST_F(CheckpointFilesTest, KilledBetweenTheTwoTheOneBeforeIsThere) {
  save("one");
  save("two");
  fs::remove(folder() / "checkpoint_R.bin");
  EXPECT_EQ(all(files()), Texts{"one"});
}

TEST_F(CheckpointFilesTest, LongerOnesThanAnyCanBeAreNotRead) {
  io::write_text_atomically(folder() / "checkpoint_R.bin", "");
  fs::resize_file(folder() / "checkpoint_R.bin", std::uintmax_t{1} << 40);
  EXPECT_EQ(all(files()), Texts{""});
}

TEST_F(CheckpointFilesTest, NothingStaysInTheEnd) {
  save("one");
  save("two");
  files().remove();
  EXPECT_TRUE(fs::is_empty(folder()));
}

}  // namespace
}  // namespace kappamu::pipeline
