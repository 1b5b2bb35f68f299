// Polygrids of the named shapes at 1,000 cells: what the bench reports, refusals included.
#include <gtest/gtest.h>

#include <string>

#include "core/mesh/shapes.h"
#include "tests/bench/bench_tools.h"

namespace kappamu::bench {
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
    // The spike ends thinner than any cell: what is left out is reported.
    EXPECT_EQ(row.at("warnings").size(), object == "spike" ? 1U : 0U) << object;
    EXPECT_EQ(row.at("largest_gap").get<double>() > 1.5, object == "spike") << object;
  }
}

}  // namespace
}  // namespace kappamu::bench
