// Where the papers' methods fail: [W] (8)'s stencil answers another equation, relaxation stands
// still far from the solution.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "studies/subjects.h"
#include "tests/stability/stability_tools.h"

namespace kappamu::studies {
namespace {

class PapersMethods : public test_cases::testing::OnDevice {};

Json rows_of(const char* section) {
  Json rows;
  Progress silent;
  for (const Section& one : limits_subject().sections) {
    if (one.name == section) one.measure({}, silent, [&](const Json& b) { rows = b.at("rows"); });
  }
  return rows;
}
/// The figure of the row that has these values.
double figure(const Json& rows, const Json& where, const char* name) {
  for (const Json& row : rows) {
    bool same = true;
    for (const auto& [key, value] : where.items()) same = same && row.at(key) == value;
    if (same) return row.at(name).get<double>();
  }
  throw std::runtime_error("no row " + where.dump());
}

TEST_F(PapersMethods, Stencil8AnswersAnotherEquationWhereKappaVaries) {
  const Json rows = rows_of("stencil");
  const auto distance = [&](const char* medium, double contrast) {
    return figure(rows, {{"κ", medium}, {"contrast", contrast}}, "distance of the maps");
  };
  for (const char* medium : {"smooth", "layers of 1 mm", "random cubes of 1 mm"}) {
    EXPECT_LT(distance(medium, 1.0), 1e-5) << "one equation where κ is even: " << medium;
    EXPECT_GT(distance(medium, 10.0), 0.1) << medium;
    EXPECT_GT(distance(medium, 10.0), distance(medium, 2.0)) << medium;
  }
  // No error of discretisation: half the voxel leaves it.
  EXPECT_NEAR(distance("smooth, voxels halved", 10.0), distance("smooth", 10.0),
              0.3 * distance("smooth", 10.0));
}

TEST_F(PapersMethods, RelaxationStandsFarFromTheSolution) {
  const Json rows = rows_of("relaxation");
  const auto at = [&](const char* block, int sweeps, const char* what,
                      const char* method = "relaxation") {
    return figure(rows, {{"block", block}, {"method", method}, {"sweeps", sweeps}}, what);
  };
  // After a thousand sweeps the answer is a fifth off, more than the residual says.
  EXPECT_GT(at("64³, even κ", 1024, "error of the maps"), 0.2);
  EXPECT_GT(at("64³, even κ", 1024, "error of the maps"), at("64³, even κ", 1024, "residual"));
  // Twice the resolution, four times the sweeps: at equal sweeps it is farther off.
  EXPECT_GT(at("64³, even κ", 1024, "error of the maps"),
            2 * at("32³, even κ", 1024, "error of the maps"));
  // More sweeps help until rounding.
  EXPECT_LT(at("16³, even κ", 1024, "error of the maps", "gauss-seidel"), 1e-4);
}

}  // namespace
}  // namespace kappamu::studies
