// Loops over rows by threads that stand by: every row once, from any thread, within each other, and
// through exceptions.
#include "core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

namespace kappamu {
namespace {

std::vector<int> calls_of(int rows, unsigned threads = 0) {
  std::vector<std::atomic<int>> calls(static_cast<std::size_t>(rows));
  for_rows(
      rows, [&](int row) { ++calls[static_cast<std::size_t>(row)]; }, threads);
  return {calls.begin(), calls.end()};
}

TEST(Parallel, CallsEveryRowOnce) {
  for (const int rows : {0, 1, 2, 3, 1000}) {
    EXPECT_EQ(calls_of(rows), std::vector<int>(static_cast<std::size_t>(rows), 1)) << rows;
  }
  EXPECT_EQ(calls_of(100, 1), std::vector<int>(100, 1));
}

TEST(Parallel, OneThreadIsTheCallers) {
  for_rows(
      100,
      [caller = std::this_thread::get_id()](int) { EXPECT_EQ(std::this_thread::get_id(), caller); },
      1);
}

TEST(Parallel, OtherThreadsTakeRows) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "one core";
  // A row that waits for another to begin ends only where two threads are at it.
  std::atomic<int> begun{0};
  for_rows(2, [&](int) {
    ++begun;
    while (begun < 2) std::this_thread::yield();
  });
  EXPECT_EQ(begun, 2);
}

TEST(Parallel, LoopsLieWithinEachOtherAndBeginInAnyThread) {
  std::atomic<int> sum{0};
  const auto nested = [&] {
    for (int k = 0; k < 50; ++k) {
      for_rows(7, [&](int) { for_rows(5, [&](int) { for_rows(3, [&](int) { ++sum; }); }); });
    }
  };
  {
    std::vector<std::jthread> callers;
    for (int c = 0; c < 4; ++c) callers.emplace_back(nested);
  }
  EXPECT_EQ(sum, 4 * 50 * 7 * 5 * 3);
}

TEST(Parallel, AnExceptionReachesTheCallerAndTheNextLoopRuns) {
  for (int k = 0; k < 100; ++k) {
    const auto fail = [&](int row) {
      if (row == k) throw std::runtime_error("row");
    };
    EXPECT_THROW(for_rows(100, fail), std::runtime_error);
  }
  EXPECT_EQ(calls_of(100), std::vector<int>(100, 1));
}

TEST(Parallel, SumsByPiecesHaveTheSameBitsOnAnyNumberOfThreads) {
  std::vector<double> values(1000);
  std::iota(values.begin(), values.end(), 0.1);
  const auto sum = [&] {
    std::vector<double> sums(pieces(values.size(), 64));
    for_pieces(values.size(), 64, [&](std::size_t piece, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) sums[piece] += 1.0 / values[i];
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
  };
  const double first = sum();
  for (int k = 0; k < 100; ++k) ASSERT_EQ(sum(), first);
}

}  // namespace
}  // namespace kappamu
