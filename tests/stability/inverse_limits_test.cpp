// The edges of the fit as docs/limits.md tables them: how good the volume still is, and that the
// program says what is wrong. Rates over many blocks are the table's (`kappamu-studies limits
// --section consistency`); here one block each.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "tests/cases/limit_inverse.h"
#include "tests/stability/stability_tools.h"

namespace kappamu::test_cases {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// What the volume must still be worth, and what must be said.
struct Bound {
  std::string name;                    ///< of inverse_limits()
  std::optional<double> most_error{};  ///< E under light not fitted; none where data are wrong
  std::string warns{};                 ///< part of a warning; empty: there is none at all
  std::string notes{};                 ///< part of a note
};
void PrintTo(const Bound& bound, std::ostream* out) {
  *out << bound.name;
}

const std::vector<Bound> bounds{
    {"1 % noise", 8e-4, "", "an error is reported beyond a factor of"},
    {"3 % noise", 1.5e-3},
    {"10 % noise", 5e-3},
    {"one pattern", 2e-2, "With fewer than four patterns"},
    {"scale 2", {}, "Check the white reference"},
    {"scale 0.5", {}, "Check the white reference"},
    {"eta 1.3 stated for 1.5", 3e-3, "of this block's mean coefficients",
     "determines its eta: kappa and mu hold for the stated 1.30"},
    {"images 1 voxel off", {}, "The images sit 1.1 voxels (0.43 mm) towards +x"},
    {"images 3 voxels off", {}, "The images sit 2.9 voxels (1.15 mm) towards +x"},
    {"start 100 times too high", 8e-4},
    {"start 100 times too low", 8e-4},
    {"inclusions of contrast 100", 2e-3, "split the voxels and compare"},
    {"3κμ = 0.3", 1e-6, "100 % of the voxels absorb more than a tenth of what they extinguish"},
    {"2 mean free paths thick", 1e-6, "albedo 0.99, 2 transport mean free paths thick"},
    {"2 mean free paths thick, data by Monte Carlo of g = 0.8, --physics auto",
     {},
     "variances, calibration or the diffusion model do not hold"},
    {"front-lit, half the face masked", 2e-3, "50 % of the seen face is measured under no pattern"},
    {"1 % of outliers", {}, "fit with the loss student, which is robust to outliers"},
    {"1 % of outliers, --loss student", 8e-4},
    {"all dark", {}, "the channel is dark; check exposure and variance, or fit the other channels"},
    {"voxels of 0.13 mean free paths", 3e-3, "", "light carries no structure finer than that"},
};

class InverseLimits : public testing::OnDevice, public ::testing::WithParamInterface<Bound> {};

TEST_P(InverseLimits, AreMetOrTold) {
  const Bound& bound = GetParam();
  const InverseLimitOutcome outcome = run_inverse_limit(inverse_limit(bound.name), "auto");
  if (bound.most_error) {
    EXPECT_LT(outcome.error, *bound.most_error);
  }
  if (bound.warns.empty()) {
    EXPECT_THAT(outcome.warnings, IsEmpty());
  } else {
    EXPECT_THAT(outcome.warnings, Contains(HasSubstr(bound.warns)));
  }
  if (!bound.notes.empty()) {
    EXPECT_THAT(outcome.notes, Contains(HasSubstr(bound.notes)));
  }
}

INSTANTIATE_TEST_SUITE_P(, InverseLimits, ::testing::ValuesIn(bounds), [](const auto& at) {
  std::string name;
  for (const char c : at.param.name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += c;
  }
  return name;
});

class TransportLimits : public testing::OnDevice {};

/// Where diffusion misses by 14 and 8 %, transport's data fitted by transport.
TEST_F(TransportLimits, AnAbsorbingBlockEndsNearTheTruth) {
  const InverseLimitOutcome outcome =
      run_inverse_limit(inverse_limit("3κμ = 0.3, data by Monte Carlo, --physics auto"), "auto");
  ASSERT_TRUE(outcome.fit);
  EXPECT_EQ(outcome.fit->report.physics, inverse::Physics::transport);
  EXPECT_LT(outcome.kappa_error, 0.05);
  EXPECT_LT(outcome.mu_error, 0.15);
}

TEST_F(TransportLimits, AVolumeEndsNearerToTheTruthThanByDiffusion) {
  const std::string name = "structure, 2.7 mean free paths thick, data by Monte Carlo";
  const InverseLimitOutcome diffusion = run_inverse_limit(inverse_limit(name), "auto");
  const InverseLimitOutcome transport =
      run_inverse_limit(inverse_limit(name + ", --physics transport"), "auto");
  ASSERT_TRUE(diffusion.fit && transport.fit);
  EXPECT_LT(transport.kappa_error, 0.5 * diffusion.kappa_error);
  EXPECT_LT(transport.mu_error, 0.7 * diffusion.mu_error);
  EXPECT_THAT(transport.warnings, IsEmpty());
}

class AnyStart : public testing::OnDevice {};

// The start decides nothing: off by 100 times either way the same volume comes out.
TEST_F(AnyStart, EndsInTheSameVolume) {
  const InverseLimitOutcome usual = run_inverse_limit(inverse_limit("1 % noise"), "auto");
  for (const char* name : {"start 100 times too high", "start 100 times too low"}) {
    const InverseLimitOutcome outcome = run_inverse_limit(inverse_limit(name), "auto");
    // Descents end where their steps stall, and roundings, which differ by processor, decide where:
    // E, which is a square, is found 0.2 to 2.3 % off; 5 % of it are 2.5 % of the light.
    EXPECT_NEAR(outcome.error / usual.error, 1.0, 0.05) << name;
  }
}

}  // namespace
}  // namespace kappamu::test_cases
