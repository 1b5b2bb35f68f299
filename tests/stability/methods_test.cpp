// Where the papers' methods fail: [W] (8)'s stencil answers another equation, relaxation stands
// still far from the solution.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench/limits.h"
#include "tests/stability/stability_tools.h"

namespace kappamu::bench {
namespace {

class PapersMethods : public testing::OnDevice {};

double number(const Record& record, const std::string& name) {
  return std::get<double>(figure(record, name));
}
const Record& find(const LimitTable& table, const std::string& name, const std::string& is,
                   const std::string& other, const Figure& value) {
  for (const Record& record : table.records) {
    if (to_text(figure(record, name)) == is && figure(record, other) == value) return record;
  }
  throw std::runtime_error("no record " + is);
}

TEST_F(PapersMethods, Stencil8AnswersAnotherEquationWhereKappaVaries) {
  Progress silent;
  const LimitTable table = limit_stencil({}, silent);
  const auto distance = [&](const char* medium, double contrast) {
    return number(find(table, "κ", medium, "contrast", contrast), "distance of the maps");
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
  Progress silent;
  const LimitTable table = limit_relaxation({}, silent);
  const auto at = [&](const char* block, int sweeps, const char* what) {
    return number(find(table, "block and method", block, "sweeps", sweeps), what);
  };
  // After a thousand sweeps the answer is a fifth off, more than the residual says.
  EXPECT_GT(at("64³, even κ, relaxation", 1024, "error of the maps"), 0.2);
  EXPECT_GT(at("64³, even κ, relaxation", 1024, "error of the maps"),
            at("64³, even κ, relaxation", 1024, "residual"));
  // Twice the resolution, four times the sweeps: at equal sweeps it is farther off.
  EXPECT_GT(at("64³, even κ, relaxation", 1024, "error of the maps"),
            2 * at("32³, even κ, relaxation", 1024, "error of the maps"));
  // More sweeps help until rounding.
  EXPECT_LT(at("16³, even κ, gauss-seidel", 1024, "error of the maps"), 1e-4);
}

}  // namespace
}  // namespace kappamu::bench
