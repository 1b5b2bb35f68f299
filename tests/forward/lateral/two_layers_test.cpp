// Two layers of lateral light, against Monte Carlo through the same two layers.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "forward/lateral/lateral_reflectance.h"
#include "forward/lateral/layered_transport.h"
#include "tests/forward/lateral/walked_layers.h"
#include "tests/sentence.h"

namespace kappamu::forward {
namespace {

using test_cases::layers_g;
using test_cases::layers_index;
using test_cases::walked;
using test_cases::Walked;

TEST(TwoLayers, AreExactWhereOneOfThemDecides) {
  const LateralReflectance half({layers_index, layers_g, {}});
  constexpr double by_table = 4e-3;
  for (const double f : {0.0, 0.1, 0.3}) {
    const double alone = half(f, 0.02, 1.0).reflectance;
    LateralMedium medium{layers_index, layers_g, {}};
    medium.cover = LateralCover{{0.02, 1.0}, 0.7};
    EXPECT_NEAR(LateralReflectance(medium)(f, 0.02, 1.0).reflectance / alone, 1.0, by_table)
        << "equal";
    medium.cover = LateralCover{{0.2, 2.0}, 1e-7};
    EXPECT_NEAR(LateralReflectance(medium)(f, 0.02, 1.0).reflectance / alone, 1.0, by_table)
        << "thin";
    LateralMedium thick{layers_index, layers_g, 100.0};
    thick.base = LateralLayer{0.2, 2.0};
    EXPECT_NEAR(LateralReflectance(thick)(f, 0.02, 1.0).reflectance / alone, 1.0, by_table)
        << "thick";
  }
}

TEST(TwoLayers, CoverAndBaseAreTheSameTwoLayers) {
  LateralMedium cover{layers_index, layers_g, {}};
  cover.cover = LateralCover{{0.1, 1.5}, 0.5};
  LateralMedium base{layers_index, layers_g, 0.5};
  base.base = LateralLayer{0.02, 1.0};
  const LayeredTransport transport(layers_index, layers_g);
  const std::array<TransportLayer, 2> layers{
      {{0.1, 1.5, 0.5}, {0.02, 1.0, std::numeric_limits<double>::infinity()}}};
  for (const double f : {0.0, 0.2}) {
    const double light = transport(layers, f).reflectance;
    constexpr double between_nodes = 2e-4;
    EXPECT_NEAR(LateralReflectance(cover)(f, 0.02, 1.0).reflectance / light, 1.0, between_nodes);
    EXPECT_NEAR(LateralReflectance(base)(f, 0.1, 1.5).reflectance / light, 1.0, between_nodes);
  }
}

TEST(TwoLayers, RefuseWhatIsNoTwoLayers) {
  LateralMedium medium{layers_index, layers_g, 1.0};
  medium.cover = LateralCover{{0.1, 1.5}, 0.5};
  EXPECT_NE(sentence_of([&] { LateralReflectance{medium}; }).find("over a half-space"),
            std::string::npos);
  LateralMedium base{layers_index, layers_g, {}};
  base.base = LateralLayer{0.02, 1.0};
  EXPECT_NE(sentence_of([&] { LateralReflectance{base}; }).find("needs its thickness"),
            std::string::npos);
}

/// Skin-like layers: a thin dark one over a bright one, a bright one over a dark one.
TEST(MonteCarloTwoLayers, AgreeWithinTheStatedError) {
  struct Case {
    LateralLayer upper, lower;
    double thickness;
  };
  constexpr std::uint64_t photons = 60000;
  for (const Case& c : {Case{{0.3, 2.0}, {0.02, 1.5}, 0.1}, Case{{0.01, 1.0}, {0.1, 2.0}, 1.0},
                        Case{{0.05, 0.7}, {0.05, 2.0}, 0.5}}) {
    LateralMedium medium{layers_index, layers_g, {}};
    medium.cover = LateralCover{c.upper, c.thickness};
    const LateralReflectance model(medium);
    for (const double f : {0.0, 0.25}) {
      const Walked mc = walked(f, c.upper, c.lower, c.thickness, photons);
      const double ours = model(f, c.lower.mua, c.lower.musp).reflectance;
      const double stated = model.relative_error(f, c.lower.mua, c.lower.musp);
      const double noise = mc.error / mc.reflectance;
      EXPECT_LT(std::abs(ours / mc.reflectance - 1.0), 2.0 * std::hypot(stated, noise))
          << "upper " << c.upper.mua << " " << c.upper.musp << " thickness " << c.thickness << " f "
          << f << ": " << mc.reflectance << " " << ours;
    }
  }
}

}  // namespace
}  // namespace kappamu::forward
