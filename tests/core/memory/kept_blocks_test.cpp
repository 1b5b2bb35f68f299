// Freed blocks that are used again: only while someone wants that, only for as much, and never
// more memory than was in use at once.
#include "core/memory/kept_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <vector>

namespace kappamu {
namespace {

constexpr std::size_t megabyte = std::size_t{1} << 20;

TEST(KeptBlocks, AreKeptOnlyWhileSomeoneWantsThat) {
  void* block = std::malloc(8 * megabyte);
  EXPECT_FALSE(keep_block(block, 8 * megabyte));
  {
    const KeepsBlocks outer;
    {
      const KeepsBlocks inner;
      EXPECT_TRUE(keep_block(block, 8 * megabyte));
    }
    EXPECT_EQ(take_kept_block(8 * megabyte), block);
    EXPECT_EQ(take_kept_block(8 * megabyte), nullptr);
    EXPECT_TRUE(keep_block(block, 8 * megabyte));
  }
  EXPECT_EQ(take_kept_block(8 * megabyte), nullptr);
}

TEST(KeptBlocks, GoToThoseWhoAskForAsMuch) {
  const KeepsBlocks keeps;
  const auto kept = [](std::size_t size) {
    void* block = std::malloc(size);
    EXPECT_TRUE(keep_block(block, size));
    return block;
  };
  void* larger = kept(18 * megabyte);
  void* nearest = kept(17 * megabyte);
  EXPECT_EQ(take_kept_block(16 * megabyte), nearest);
  EXPECT_EQ(take_kept_block(16 * megabyte), larger);
  kept(18 * megabyte + 1);  // an eighth more than it is asked for
  EXPECT_EQ(take_kept_block(16 * megabyte), nullptr);
  std::free(larger);
  std::free(nearest);
}

/// Blocks that come and go at random; the most that was held beyond the most in use.
std::size_t most_beyond_use(std::size_t spare, double* share_kept) {
  const KeepsBlocks keeps(spare);
  struct Block {
    void* begin;
    std::size_t size;
  };
  std::vector<Block> used, kept;
  std::mt19937 random(7);
  std::size_t in_use = 0, most_in_use = 0, beyond = 0, taken = 0, again = 0;
  const auto total = [](const std::vector<Block>& blocks) {
    std::size_t sum = 0;
    for (const Block& block : blocks) sum += block.size;
    return sum;
  };
  for (int step = 0; step < 4000; ++step) {
    if (!used.empty() && (used.size() > 20 || random() % 2 == 0)) {
      std::swap(used[random() % used.size()], used.back());
      EXPECT_TRUE(keep_block(used.back().begin, used.back().size));
      kept.push_back(used.back());
      used.pop_back();
    } else {
      const std::size_t size = 1000 * (1 + random() % 50);
      ++taken;
      if (void* block = take_kept_block(size)) {
        ++again;
        const auto found = std::find_if(kept.begin(), kept.end(),
                                        [&](const Block& one) { return one.begin == block; });
        if (found == kept.end()) {
          ADD_FAILURE() << "a block that was given back";
          break;
        }
        EXPECT_GE(found->size, size);
        used.push_back(*found);
        kept.erase(found);
      } else {
        for (std::size_t dropped = 0; dropped < size && total(kept) > spare;) {
          dropped += kept.front().size;
          kept.erase(kept.begin());
        }
        used.push_back({std::malloc(size), size});
      }
    }
    if (kept.size() > 64) kept.erase(kept.begin());
    in_use = total(used);
    most_in_use = std::max(most_in_use, in_use);
    beyond = std::max(beyond, std::max(in_use + total(kept), most_in_use) - most_in_use);
  }
  for (const Block& block : used) std::free(block.begin);
  *share_kept = static_cast<double>(again) / static_cast<double>(taken);
  return beyond;
}

TEST(KeptBlocks, HoldNoMoreThanWasInUseAtOnceAndWhatIsSpare) {
  constexpr std::size_t spare = 300'000;
  double without = 0.0, with = 0.0;
  EXPECT_EQ(most_beyond_use(0, &without), 0U);
  EXPECT_LE(most_beyond_use(spare, &with), spare);
  EXPECT_GT(without, 0.1);
  EXPECT_GT(with, without);
}

}  // namespace
}  // namespace kappamu
