// hypre's PFMG gives our solution: what is compared is the same problem. Whether it is there
// depends on the machine (scripts/setup.sh --peers).
#include <gtest/gtest.h>

#include "studies/forward/peer_runner.h"
#include "tests/studies/bench_tools.h"

namespace kappamu::studies {

namespace {

class PeerTest : public FolderTest {
 protected:
  /// y longer than z, and z longer than y: the peers' slabs lie across either.
  void agree(const GridShape& shape) const {
    if (!has_peer()) GTEST_SKIP() << "no peer was built; scripts/setup.sh --peers";
    const Problem problem({"peers", shape, test_cases::reference_inclusions(), 2, 2}, "auto");
    const PeerRun run = run_peer(problem, 2, {1e-4, 1e-10}, 1, folder() / "exchange");
    ASSERT_EQ(run.samples.size(), 2U);
    // A residual of 1e-10 leaves an error of the same size, times what the contrast allows.
    constexpr double tolerance = 1e-8;
    EXPECT_LT(run.samples[1].error().value(), tolerance);
    EXPECT_GT(run.samples[0].error().value(), run.samples[1].error().value());
    EXPECT_GT(run.samples[1].iterations, run.samples[0].iterations);
    EXPECT_GT(run.samples[1].solve_seconds_per_rhs, 0.0);
    EXPECT_FALSE(run.setting.empty());
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
}  // namespace kappamu::studies
