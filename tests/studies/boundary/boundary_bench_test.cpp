// Boundary integrals with a prescribed solution: what the bench reports of them.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/studies/bench_tools.h"

namespace kappamu::studies {
namespace {

class BoundaryBench : public RecordTest {};

TEST_F(BoundaryBench, ErrorsFallAsOneOverTrianglesAndSlowerAtEdges) {
  const Json rows = quick_record("boundary", "boundary").at("rows");
  ASSERT_EQ(rows.size(), 4U);
  for (std::size_t first = 0; first < rows.size(); first += 2) {
    const auto number = [&](std::size_t row, const char* key) {
      return rows.at(first + row).at(key).get<double>();
    };
    const double order = std::log(number(0, "error") / number(1, "error")) /
                         std::log(number(1, "triangles") / number(0, "triangles"));
    const bool edges = rows.at(first).at("shape") == "cube";
    EXPECT_GE(order, edges ? 0.55 : 0.85) << rows.at(first).at("shape");
    EXPECT_LE(number(1, "sum_error"), 1e-5);
    EXPECT_LE(number(1, "iterations"), 12.0);
  }
}

}  // namespace
}  // namespace kappamu::studies
