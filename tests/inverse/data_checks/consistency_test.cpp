// Data that are not what they claim to be: a wrong scale, eta or pose is told, with its amount; a
// structured or layered block with right data is not accused. How often, over many blocks, is
// not asked here.
#include "inverse/data_checks/consistency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "inverse/block_model/homogeneous.h"
#include "tests/cases/limit_inverse_case.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr ModelError model_error{0.001, 5e-5};

test_cases::Block block() {
  test_cases::Block b;
  b.grid = {12, 12, 6, 0.5};
  return b;
}

struct Checked {
  Consistency consistency;
  std::vector<std::string> warnings;
};

Checked check(const test_cases::Figure3& truth, const test_cases::Mistake& mistake,
              double eta = 1.3, int side = 4) {
  SurfaceMeasurements m = test_cases::expose_figure(block(), truth, side, 2, eta);
  test_cases::spoil(m, block().noise, mistake);
  const Problem problem = make_problem(m, 0, forward::Convention::physical, model_error);
  const HomogeneousFit start = find_homogeneous(problem);
  Checked checked;
  checked.consistency = check_consistency(problem, start.kappa, start.mu, model_error, {});
  checked.warnings = warnings_of(checked.consistency, problem);
  if (shifted_channel({&checked.consistency, 1})) {
    checked.warnings.push_back(
        shift_sentence(checked.consistency, problem.setup.shape, problem.seen_face));
  }
  return checked;
}

TEST(Consistency, RightDataAreNotAccused) {
  for (const test_cases::Figure3& truth :
       {test_cases::even_block(0.2, 0.02), test_cases::layered_block(0.2, 0.02),
        test_cases::structured_block(0.15, 0.005, 1.0, 0),
        test_cases::structured_block(0.3, 0.02, 1.0, 1)}) {
    EXPECT_THAT(check(truth, {}).warnings, IsEmpty());
  }
}

TEST(Consistency, WrongScaleOfAHomogeneousBlockIsMeasured) {
  for (const double scale : {0.5, 1.2, 1.5, 2.0}) {
    const Checked checked = check(test_cases::even_block(0.2, 0.02), {.scale = scale});
    EXPECT_TRUE(checked.consistency.explained);
    constexpr double one_percent = 0.01;
    EXPECT_NEAR(std::exp(checked.consistency.log_scale.value) / scale, 1.0, one_percent);
    EXPECT_THAT(checked.warnings, ElementsAre(HasSubstr("Check the white reference")));
  }
}

TEST(Consistency, TwiceTheScaleIsToldOfAStructuredBlock) {
  const Checked checked = check(test_cases::structured_block(0.3, 0.02, 1.0, 1), {.scale = 2.0});
  EXPECT_FALSE(checked.consistency.explained);
  ASSERT_THAT(checked.warnings, ElementsAre(HasSubstr("times (")));
  EXPECT_THAT(checked.warnings.front(), HasSubstr("what a homogeneous block would show"));
}

TEST(Consistency, WrongEtaOfAHomogeneousBlockIsNamed) {
  const Checked checked = check(test_cases::even_block(0.2, 0.02), {.stated_eta = 1.3}, 1.5);
  ASSERT_TRUE(checked.consistency.other_eta.has_value());
  EXPECT_EQ(*checked.consistency.other_eta, 1.5);
  EXPECT_THAT(checked.warnings, ElementsAre(HasSubstr("with eta 1.50, not with the stated 1.30")));
}

TEST(Consistency, ShiftIsToldInVoxelsAndDirection) {
  for (const double shift : {1.0, 3.0}) {
    for (const test_cases::Figure3& truth :
         {test_cases::even_block(0.2, 0.02), test_cases::structured_block(0.15, 0.005, 1.0, 0)}) {
      const Checked checked = check(truth, {.shift = shift});
      constexpr double quarter_voxel = 0.25;
      EXPECT_NEAR(checked.consistency.shift_u.value, shift, quarter_voxel);
      EXPECT_NEAR(checked.consistency.shift_v.value, 0.0, quarter_voxel);
      ASSERT_THAT(checked.warnings, ElementsAre(HasSubstr("towards +x")));
      EXPECT_THAT(checked.warnings.front(), HasSubstr("check the sample pose"));
    }
  }
}

// A structured block's blue channel may look shifted where its red one does not.
TEST(Consistency, AShiftIsOneOfAllChannels) {
  const auto channel = [](double u) {
    Consistency c;
    c.checked = true;
    c.shift_u.value = u;
    c.shift_limit = 0.5;
    return c;
  };
  const Consistency unchecked;
  EXPECT_EQ(shifted_channel(std::vector{channel(-0.8), channel(-0.6), channel(-0.7)}), 1U);
  EXPECT_EQ(shifted_channel(std::vector{channel(0.8), unchecked}), 0U);
  EXPECT_EQ(shifted_channel(std::vector{channel(0.8), channel(0.3), channel(0.9)}), std::nullopt);
  EXPECT_EQ(shifted_channel(std::vector{unchecked}), std::nullopt);
}

TEST(Consistency, FewPatternsAreSaidToTellNothing) {
  EXPECT_THAT(check(test_cases::even_block(0.2, 0.02), {}, 1.3, 1).warnings,
              ElementsAre(HasSubstr("With fewer than four patterns")));
}

}  // namespace
}  // namespace kappamu::inverse
