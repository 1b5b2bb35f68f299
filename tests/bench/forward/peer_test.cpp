// Other people's solvers give our solution: what is compared is the same problem. Which of them is
// there depends on the machine (scripts/setup.sh --peers).
#include <gtest/gtest.h>

#include "bench/forward/peer_runner.h"
#include "tests/bench/bench_tools.h"

namespace kappamu::bench {

namespace {

class PeerTest : public FolderTest {
 protected:
  /// y longer than z, and z longer than y: the peers' slabs lie across either.
  void agree(const GridShape& shape) const {
    const auto peers = available_peers();
    if (peers.empty()) GTEST_SKIP() << "no peers were built; scripts/setup.sh --peers";
    const Problem problem({"peers", shape, reference_inclusions(), 2, 2}, "auto");
    for (const std::string& peer : peers) {
      const PeerRun run = run_peer(problem, peer, 2, {1e-4, 1e-10}, 1, folder() / "exchange");
      ASSERT_EQ(run.samples.size(), 2U) << peer;
      // A residual of 1e-10 leaves an error of the same size, times what the contrast allows.
      constexpr double tolerance = 1e-8;
      EXPECT_LT(run.samples[1].error(), tolerance) << peer;
      EXPECT_GT(run.samples[0].error(), run.samples[1].error()) << peer;
      EXPECT_GT(run.samples[1].iterations, run.samples[0].iterations) << peer;
      EXPECT_GT(run.samples[1].solve_seconds_per_rhs, 0.0) << peer;
      EXPECT_FALSE(run.setting.empty()) << peer;
    }
    EXPECT_FALSE(std::filesystem::exists(folder() / "exchange"));
  }
};

TEST_F(PeerTest, GiveOurSolutionOnAWideBlock) {
  agree({11, 12, 5, 0.25});
}

TEST_F(PeerTest, GiveOurSolutionOnATallBlock) {
  agree({7, 5, 12, 0.25});
}

}  // namespace
}  // namespace kappamu::bench
