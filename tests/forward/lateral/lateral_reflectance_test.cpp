// Laws of lateral reflectance: closed-form diffusion against the layered solver, the table against
// white Monte Carlo runs at indices, anisotropies and seeds that it was not made from. Real
// photographs are `kappamu-studies sfdi`.
#include "forward/lateral/lateral_reflectance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/optics.h"
#include "forward/analytic/layered_mode.h"
#include "forward/lateral/half_space_walk.h"
#include "forward/lateral/lateral_diffusion.h"
#include "tests/sentence.h"

namespace kappamu::forward {
namespace {

constexpr double A = 2.9;

TEST(LateralDiffusion, EqualsTheLayeredHalfSpace) {
  for (const double a : {1e-3, 0.03, 0.7}) {
    for (const double k : {0.0, 0.4, 3.0}) {
      const Layer layer{1.0 / (3.0 * (1.0 + a)), a, std::numeric_limits<double>::infinity()};
      const LayeredMode mode({&layer, 1}, A, {k * k, 1.0, 0.0});
      const double layered = mode.flux_out_near();
      EXPECT_NEAR(diffuse_half_space(a, k, A) / layered, 1.0, 1e-9) << a << " " << k;
    }
  }
}

TEST(LateralDiffusion, ThickSlabIsAHalfSpaceAndThinOneIsDarker) {
  EXPECT_NEAR(slab_over_half_space(0.1, 0.5, A, A, 60.0), 1.0, 1e-9);
  double before = 0.0;
  for (const double thickness : {0.5, 1.0, 3.0, 10.0, 30.0}) {
    const double ratio = slab_over_half_space(0.02, 0.0, A, A, thickness);
    EXPECT_GT(ratio, before);
    EXPECT_LT(ratio, 1.0);
    before = ratio;
  }
}

TEST(HalfSpaceWalk, AllLightLeavesWhereNothingAbsorbs) {
  WalkOptions options;
  options.anisotropy = 0.7;
  options.indices = {1.0, 1.4};
  options.photons = 40000;
  options.seed = 11;
  const std::vector<LateralPoint> white{{0.0, 0.0}};
  const WhiteReflectance walk = walk_half_space(options, white);
  for (std::size_t i = 0; i < options.indices.size(); ++i) {
    // Paths beyond 6e4/σs' are cut: 1 % of the light.
    EXPECT_NEAR(walk.value[i], 1.0, 4.0 * walk.standard_error[i] + 0.01) << i;
  }
}

TEST(LateralReflectance, HoldsMonteCarloBetweenItsNodes) {
  WalkOptions options;
  options.anisotropy = 0.86;
  options.indices = {1.36, 1.45};
  options.photons = 150000;
  options.seed = 77;
  const std::vector<LateralPoint> points{{0.01, 0.0}, {0.1, 0.0},  {0.03, 0.6},
                                         {0.03, 1.3}, {0.15, 1.3}, {0.06, 2.6}};
  const WhiteReflectance walk = walk_half_space(options, points);
  double chi_square = 0.0;
  for (std::size_t n = 0; n < options.indices.size(); ++n) {
    const LateralReflectance table({options.indices[n], options.anisotropy, {}});
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double musp = 1.3, mua = points[i].a * musp;
      const double f = points[i].k * musp / (2.0 * std::numbers::pi);
      const double expected = table(f, mua, musp).reflectance;
      const std::size_t at = n * points.size() + i;
      const double error =
          std::hypot(walk.standard_error[at], expected * table.relative_error(f, mua, musp));
      const double residual = (walk.value[at] - expected) / error;
      EXPECT_LT(std::abs(residual), 4.0) << n << " " << i << " " << expected;
      chi_square += residual * residual;
    }
  }
  EXPECT_LT(chi_square, 36.0);  // 12 values: exceeded by chance in 3 of 10000 runs
}

TEST(LateralReflectance, DerivativesAreThoseOfTheValue) {
  for (const std::optional<double> thickness : {std::optional<double>(), std::optional(4.0)}) {
    const LateralReflectance model({1.38, 0.82, thickness});
    for (const double f : {0.0, 0.05, 0.3}) {
      const double mua = 0.021, musp = 0.9, step = 1e-4;
      const LateralValue value = model(f, mua, musp);
      const double by_mua = (model(f, mua * (1 + step), musp).reflectance -
                             model(f, mua * (1 - step), musp).reflectance) /
                            (2 * step * mua);
      const double by_musp = (model(f, mua, musp * (1 + step)).reflectance -
                              model(f, mua, musp * (1 - step)).reflectance) /
                             (2 * step * musp);
      // A slab's are one-sided differences of step 1e-4.
      const double tolerance = thickness ? 2e-3 : 1e-6;
      EXPECT_NEAR(value.d_mua / by_mua, 1.0, tolerance) << f;
      EXPECT_NEAR(value.d_musp / by_musp, 1.0, tolerance) << f;
    }
  }
}

TEST(LateralReflectance, FallsWithAbsorptionAndFrequencyAndReachesOne) {
  const LateralReflectance model({1.4, 0.9, {}});
  EXPECT_NEAR(model(0.0, 1e-9, 1.0).reflectance, 1.0, 1e-3);
  double before = 1.0;
  for (const double f : {0.0, 0.05, 0.1, 0.2, 0.4, 0.8}) {
    const LateralValue value = model(f, 0.02, 1.0);
    EXPECT_LT(value.reflectance, before) << f;
    EXPECT_LT(value.d_mua, 0.0) << f;
    before = value.reflectance;
  }
}

TEST(LateralReflectance, RefusesWhatItsTableDoesNotHold) {
  const auto sentence = [](LateralMedium medium) {
    return sentence_of([&] { LateralReflectance model(medium); });
  };
  EXPECT_NE(sentence({1.6, 0.9, {}}).find("refractive index 1.6"), std::string::npos);
  EXPECT_NE(sentence({1.4, 0.5, {}}).find("anisotropy 0.5"), std::string::npos);
  EXPECT_NE(sentence({1.4, 0.9, 0.0}).find("thickness"), std::string::npos);
}

}  // namespace
}  // namespace kappamu::forward
