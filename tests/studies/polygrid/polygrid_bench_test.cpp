// Polygrids of the named shapes at 1,000 cells: what the bench reports, refusals included.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "core/mesh/shapes.h"
#include "tests/studies/bench_tools.h"

namespace kappamu::studies {
namespace {

class PolygridBench : public RecordTest {};

TEST_F(PolygridBench, GivesNumbersOrOneSentenceForEveryShape) {
  const Json rows = quick_record("polygrid", "polygrid").at("rows");
  ASSERT_EQ(rows.size(), named_shapes().size());
  for (const Json& row : rows) {
    const auto object = row.at("object").get<std::string>();
    if (object == "sheet" || object == "box-with-void" || object == "split-cube") {
      const auto sentence = row.at("refused").get<std::string>();
      EXPECT_NE(sentence.find(object == "sheet" ? "take more cells" : "one piece; this one has 2"),
                std::string::npos)
          << sentence;
      continue;
    }
    EXPECT_EQ(row.at("inverted"), 0) << object;
    EXPECT_GE(row.at("least_jacobian").get<double>(), 0.2) << object;
    // The spike ends thinner than any cell, and so does the candle's wall: what is left out or
    // added is reported.
    EXPECT_EQ(row.at("warnings").size(), object == "spike" || object == "candle" ? 1U : 0U)
        << object << row.at("warnings");
    EXPECT_EQ(row.at("largest_gap").get<double>() > 1.5, object == "spike") << object;
  }
}

// Toy sizes: that phases are measured and an edit takes less than the first frame, not how fast.
TEST_F(PolygridBench, FramesHaveTheirPhases) {
  Request request;
  request.settings["files"] = {KAPPAMU_SOURCE_DIR "/scenes/meshes/spot.ply"};
  const Json rows = quick_record("polygrid", "frames", request).at("rows");
  ASSERT_EQ(rows.size(), 1U);
  const Json& row = rows[0];
  const auto ms = [&](const char* name) { return row.at(name).get<double>(); };
  EXPECT_NEAR(ms("frame_ms"), ms("light_ms") + ms("diffusion_ms") + ms("exitance_ms"), 1e-6);
  EXPECT_GT(ms("frame_ms"), 0.0);
  EXPECT_LT(row.at("iterations"), row.at("first_iterations"));
  EXPECT_GT(row.at("edit_voxels"), 0);
  EXPECT_GT(row.at("edit_iterations"), 0);
  EXPECT_LE(row.at("edit_iterations"), row.at("first_iterations"));
  EXPECT_LT(ms("error"), 0.02);
}

// On toy sizes: every scheme converges to its own answer, ours on fewer nodes than plain
// relaxation.
TEST_F(PolygridBench, EverySchemeConverges) {
  const Json rows = quick_record("polygrid", "convergence").at("rows");
  std::map<std::string, double> nodes;
  for (const Json& row : rows) {
    const auto scheme = row.at("scheme").get<std::string>();
    if (row.at("error").get<double>() <= 1e-4 && !nodes.contains(scheme)) {
      nodes[scheme] = row.at("nodes").get<double>();
    }
  }
  for (const char* scheme : {"plain", "hierarchical", "multigrid and conjugate gradients"}) {
    ASSERT_TRUE(nodes.contains(scheme)) << scheme;
  }
  EXPECT_LT(nodes["multigrid and conjugate gradients"], nodes["plain"]);
}

}  // namespace
}  // namespace kappamu::studies
