// The sentences a user reads where the grid or diffusion itself is at its edge.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "forward/diffusion_warnings.h"
#include "tests/cases/media.h"

namespace kappamu::test_cases {
namespace {

using forward::diffusion_warnings;
using forward::GridSetup;
using forward::Precision;
using forward::SourceModel;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::vector<std::string> warnings(const GridSetup& setup, const MediumSpec& spec) {
  return diffusion_warnings(setup, make_medium(setup.shape, spec), Precision::single_precision);
}

TEST(Warnings, AreSilentWhereAllIsWell) {
  EXPECT_THAT(warnings({.shape = {8, 8, 20, 0.5}}, {.mean_kappa = 0.3, .mu = 0.01}), IsEmpty());
}

TEST(Warnings, NameVoxelsBeyondTheMeanFreePath) {
  EXPECT_THAT(warnings({.shape = {8, 8, 20, 0.5}}, {.mean_kappa = 0.1, .mu = 0.01}),
              ElementsAre(AllOf(HasSubstr("in 100 % of the block the voxel edge of 0.5 mm is more "
                                          "than 1 mean free path 3 kappa"),
                                HasSubstr("up to 1.67"), HasSubstr("split the voxels"))));
}

TEST(Warnings, AllowCoarserVoxelsUnderTheBoundarySource) {
  const GridSetup setup{.shape = {8, 8, 20, 0.5}, .source = SourceModel::boundary};
  EXPECT_THAT(warnings(setup, {.mean_kappa = 0.1, .mu = 0.01}), IsEmpty());
  EXPECT_THAT(warnings(setup, {.mean_kappa = 0.04, .mu = 0.01}),
              ElementsAre(HasSubstr("more than 4 mean free paths 3 kappa")));
}

TEST(Warnings, CountTheCoarseVoxelsOfAMixture) {
  const Medium half =
      make_medium({8, 8, 20, 0.5}, {.kind = MediumKind::layers, .contrast = 9, .mean_kappa = 0.3});
  EXPECT_THAT(diffusion_warnings({.shape = {8, 8, 20, 0.5}}, half, Precision::single_precision),
              ElementsAre(HasSubstr("in 50 % of the block")));
}

TEST(Warnings, GiveDiffusionsMeasuredErrorInBlocksThinnerThanAFewMeanFreePaths) {
  // The table's albedo 0.99 at 2 mean free paths: 19.6 % in the far face's map.
  EXPECT_THAT(warnings({.shape = {8, 8, 4, 0.5}}, {.mean_kappa = 0.3, .mu = 0.01}),
              ElementsAre(AllOf(HasSubstr("albedo 0.99, 2.2 transport mean free paths thick"),
                                HasSubstr("9.6 % in the far face's map"))));
}

TEST(Warnings, NameAbsorptionThatRivalsScattering) {
  EXPECT_THAT(
      warnings({.shape = {8, 8, 20, 0.5}}, {.mean_kappa = 0.3, .mu = 0.2}),
      ElementsAre(HasSubstr("% in the light reflected"), HasSubstr("absorb more than a tenth")));
  EXPECT_THAT(warnings({.shape = {8, 8, 20, 0.5}}, {.mean_kappa = 0.3, .mu = 1.2}),
              Contains(HasSubstr("in 1280 voxels no scattering is left")));
}

TEST(Warnings, FindAbsorptionInPartsOfABlockWhoseMeanIsClear) {
  const GridSetup setup{.shape = {8, 8, 20, 0.5}};
  Medium medium = make_medium(setup.shape, {.mean_kappa = 0.3, .mu = 0.001});
  for (std::size_t i = 0; i < medium.mu.size() / 20; ++i) medium.mu[i] = 0.15;
  EXPECT_THAT(diffusion_warnings(setup, medium, Precision::single_precision),
              ElementsAre(HasSubstr("5 % of the voxels absorb more than a tenth")));
}

TEST(Warnings, SayHowToSeeAVeryDarkFarSide) {
  // √(0.1/0.3) · 30 mm = 17.3 e-foldings, 7.5 decades
  const GridSetup setup{.shape = {8, 8, 60, 0.5}};
  const MediumSpec spec{.mean_kappa = 0.3, .mu = 0.1};
  EXPECT_THAT(warnings(setup, spec),
              Contains(AllOf(HasSubstr("light falls by about 8 decades across the block"),
                             HasSubstr("double precision and the tolerance 1e-8"))));
  EXPECT_THAT(warnings({.shape = {8, 8, 200, 0.5}}, spec),
              Contains(AllOf(HasSubstr("25 decades"), HasSubstr("no precision resolves it"))));
  // What is double already needs the tolerance only.
  EXPECT_THAT(
      diffusion_warnings(setup, make_medium(setup.shape, spec), Precision::double_precision),
      AllOf(Contains(HasSubstr("unless you ask for the tolerance 1e-8")),
            Each(Not(HasSubstr("double")))));
}

}  // namespace
}  // namespace kappamu::test_cases
