#include "core/threads/side_by_side.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <barrier>
#include <thread>

#include "core/error.h"

namespace kappamu {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Heard : Progress {
  std::vector<std::string> stages, details, warnings;
  std::vector<double> fractions;
  void update(const std::string& stage, double fraction, const std::string& detail) override {
    stages.push_back(stage);
    fractions.push_back(fraction);
    details.push_back(detail);
  }
  void warn(const std::string& sentence) override { warnings.push_back(sentence); }
};

TEST(SideBySide, OneAtATimeIsInOrderAndInTheCallersThread) {
  Heard heard;
  const auto caller = std::this_thread::get_id();
  std::vector<std::size_t> order;
  side_by_side("fit", {"R", "G", "B"}, 1, heard, [&](std::size_t i, Progress& progress) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    order.push_back(i);
    progress.update("fit " + std::to_string(i), 0.5, "here");
  });
  EXPECT_THAT(order, ElementsAre(0, 1, 2));
  EXPECT_THAT(heard.stages, ElementsAre("fit 0", "fit 1", "fit 2"));
}

TEST(SideBySide, WorksRunTogetherAndAreShownAsOne) {
  Heard heard;
  std::barrier all_here(3);
  side_by_side("fit", {"R", "G", "B"}, 3, heard, [&](std::size_t i, Progress& progress) {
    all_here.arrive_and_wait();  // none would pass alone
    progress.update("fit", 1.0, "done");
    if (i == 1) progress.warn("green");
  });
  EXPECT_THAT(heard.stages, ElementsAre("fit R, G, B", "fit R, G, B", "fit R, G, B"));
  EXPECT_NEAR(heard.fractions.front(), 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(heard.fractions.back(), 1.0, 1e-12);
  EXPECT_THAT(heard.details.front(), HasSubstr(": done"));
  EXPECT_THAT(heard.warnings, ElementsAre("green"));
}

TEST(SideBySide, WarningsComeInTheOrderOfNames) {
  Heard heard;
  std::barrier all_here(3);
  side_by_side("fit", {"R", "G", "B"}, 3, heard, [&](std::size_t i, Progress& progress) {
    const auto warn_in_turn = [&](std::size_t who, const std::string& sentence) {
      if (i == who) progress.warn(sentence);
      all_here.arrive_and_wait();
    };
    warn_in_turn(2, "third");
    warn_in_turn(0, "first");
    warn_in_turn(1, "second");
    warn_in_turn(0, "first again");
  });
  EXPECT_THAT(heard.warnings, ElementsAre("first", "first again", "second", "third"));
}

TEST(SideBySide, TheFirstFailureEndsTheOthersAndIsRethrown) {
  Progress silent;
  std::barrier both_here(2);
  bool cancelled = false;
  const auto run = [&] {
    side_by_side("fit", {"R", "G", "B"}, 2, silent, [&](std::size_t i, Progress& progress) {
      ASSERT_LT(i, 2U) << "nothing new begins after a failure";
      both_here.arrive_and_wait();
      if (i == 0) throw InputError("no light");
      try {
        while (true) {
          progress.update("fit", 0.1, "");
          std::this_thread::yield();
        }
      } catch (const Cancelled&) {
        cancelled = true;
        throw;
      }
    });
  };
  EXPECT_THROW(run(), InputError);
  EXPECT_TRUE(cancelled);
}

}  // namespace
}  // namespace kappamu
