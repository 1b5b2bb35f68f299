// `kappamu-studies dipole` in its quick form: every section runs, and its rows hold what
// docs/dipole.md states.
#include <gtest/gtest.h>

#include "tests/studies/bench_tools.h"

namespace kappamu::studies {
namespace {

class DipoleBench : public RecordTest {};

TEST_F(DipoleBench, HierarchyIsTimedAndItsErrorMeasured) {
  const Json row = quick_record("dipole", "hierarchy").at("rows").at(0);
  EXPECT_EQ(row.at("triangles"), 2016);
  EXPECT_LT(row.at("error"), 0.01);
  EXPECT_GT(row.at("static_cpu_ms"), 0.0);
  EXPECT_LT(row.at("links_moved").get<double>(),
            0.1 * row.at("links_per_triangle").get<double>() * row.at("triangles").get<double>());
}

TEST_F(DipoleBench, ALargeTriangleMeetsAllOthersAndAGroupSharesItsList) {
  for (const Json& row : quick_record("dipole", "lists").at("rows")) {
    const auto longest = row.at("longest").get<double>();
    EXPECT_LE(row.at("shared, longest"), row.at("longest")) << row;
    if (row.at("steps") != "near leaves, by triangles") continue;
    if (row.at("mesh") == "torus on a plate") {
      EXPECT_GT(longest, 500.0);
      EXPECT_LT(row.at("shared, longest").get<double>(), 0.1 * longest);
    } else {
      EXPECT_LT(longest, 200.0);
    }
  }
}

TEST_F(DipoleBench, FormFactorsOfNearTrianglesAreExactWherePointsAreNot) {
  const Json row = quick_record("dipole", "point-sampling").at("rows").at(1);
  EXPECT_GT(row.at("points a pair"), 2.0);
  EXPECT_LT(row.at("error of form factors"), 0.1 * row.at("error of points").get<double>());
}

TEST_F(DipoleBench, AShapeThatDeformsIsAnsweredAsFromScratch) {
  const Json row = quick_record("dipole", "deform").at("rows").at(0);
  EXPECT_LT(row.at("from_scratch"), 0.01);
  EXPECT_GT(row.at("frames_per_second"), 0.0);
}

TEST_F(DipoleBench, FormFactorsAreWithinOnePerCent) {
  const Json record = quick_record("dipole", "form-factors");
  const Json& ours = record.at("rows").back();
  EXPECT_EQ(ours.at("within_1_percent"), 1.0);
  EXPECT_LT(ours.at("samples"), record.at("rows").at(1).at("samples"));
}

TEST_F(DipoleBench, TheDipoleIsNearTransportWhereLittleIsAbsorbed) {
  for (const Json& row : quick_record("dipole", "profiles").at("rows")) {
    if (row.at("albedo") != 0.99) continue;
    EXPECT_LT(std::abs(row.at("dipole").get<double>()), 0.03) << row;
  }
}

TEST_F(DipoleBench, ThinCylindersCreateEnergy) {
  const Json record = quick_record("dipole", "energy");
  EXPECT_GT(record.at("rows").at(0).at("discs_with_exact_moments"), 1.0);
  EXPECT_LT(record.at("rows").back().at("discs_with_exact_moments"), 1.0);
}

}  // namespace
}  // namespace kappamu::studies
