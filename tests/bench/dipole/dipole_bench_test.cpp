// `kappamu bench dipole` in its quick form.
#include <gtest/gtest.h>

#include "tests/bench/bench_tools.h"

namespace kappamu::bench {
namespace {

class DipoleBench : public RecordTest {};

TEST_F(DipoleBench, HierarchyIsTimedAndItsErrorMeasured) {
  const Json row = quick_record("dipole", "hierarchy").at("rows").at(0);
  EXPECT_EQ(row.at("triangles"), 2016);
  EXPECT_LT(row.at("error"), 0.01);
  EXPECT_GT(row.at("static_cpu_ms"), 0.0);
  EXPECT_EQ(row.at("relinked_frames"), 0);
}

}  // namespace
}  // namespace kappamu::bench
