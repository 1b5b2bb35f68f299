// Transport in layers by spherical harmonics, against what it must be: diffusion where that holds,
// the table of half-spaces, which Monte Carlo made, and layers that are none.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "core/optics.h"
#include "forward/lateral/lateral_diffusion.h"
#include "forward/lateral/lateral_reflectance.h"
#include "forward/lateral/lateral_stack.h"
#include "forward/lateral/layered_transport.h"

namespace kappamu::forward {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr double stack_index = 1.4;

TEST(LayeredTransport, IsTheTablesHalfSpace) {
  for (const double g : {0.7, 0.8, 0.9}) {
    const LayeredTransport transport(stack_index, g);
    const LateralReflectance table({stack_index, g});
    for (const double mua : {0.003, 0.03, 0.3}) {
      for (const double f : {0.0, 0.05, 0.2, 0.4}) {
        const std::array<TransportLayer, 1> half{{{mua, 1.5, endless}}};
        EXPECT_NEAR(transport(half, f).reflectance / table(f, mua, 1.5).reflectance, 1.0, 0.01)
            << "g " << g << " mua " << mua << " f " << f;
      }
    }
  }
}

TEST(LayeredTransport, TendsToDiffusionWhereLittleIsAbsorbed) {
  const LayeredTransport transport(stack_index, 0.0);
  constexpr double a = 1e-6;
  const std::array<TransportLayer, 1> half{{{a, 1.0, endless}}};
  const double diffusion = diffuse_half_space(a, 0.0, boundary_constants(stack_index).A);
  EXPECT_NEAR((1.0 - transport(half, 0.0).reflectance) / (1.0 - diffusion), 1.0, 0.02);
}

TEST(LayeredTransport, ConservesLight) {
  const LayeredTransport transport(stack_index, 0.9);
  for (const double thickness : {0.3, 2.0, 20.0}) {
    const std::array<TransportLayer, 1> slab{{{0.0, 1.0, thickness}}};
    const LayeredLight light = transport(slab, 0.0);
    EXPECT_NEAR(light.reflectance + light.transmittance, 1.0, 1e-6) << thickness;
  }
}

TEST(LayeredTransport, LayersOfOneMediumAreNone) {
  const LayeredTransport transport(stack_index, 0.9);
  for (const double f : {0.0, 0.15}) {
    const std::array<TransportLayer, 1> one{{{0.05, 1.2, endless}}};
    const std::array<TransportLayer, 3> three{
        {{0.05, 1.2, 0.2}, {0.05, 1.2, 1.3}, {0.05, 1.2, endless}}};
    EXPECT_NEAR(transport(three, f).reflectance / transport(one, f).reflectance, 1.0, 1e-9);
    const std::array<TransportLayer, 1> slab{{{0.05, 1.2, 3.0}}};
    const std::array<TransportLayer, 2> parts{{{0.05, 1.2, 0.7}, {0.05, 1.2, 2.3}}};
    EXPECT_NEAR(transport(parts, f).transmittance / transport(slab, f).transmittance, 1.0, 1e-9);
  }
}

/// Equal σs' is not equal light: through an absorbing slab isotropic scattering is 12 to 17 %
/// brighter than g 0.9.
TEST(LayeredTransport, AnisotropyMattersWhereLightIsAbsorbed) {
  const LayeredTransport isotropic(stack_index, 0.0), forwards(stack_index, 0.9);
  for (const double thickness : {2.0, 4.0, 8.0}) {
    const auto through = [&](const LayeredTransport& transport, double mua) {
      const std::array<TransportLayer, 1> slab{{{mua, 1.0, thickness}}};
      return transport(slab, 0.0).transmittance;
    };
    const double dark = through(isotropic, 0.1) / through(forwards, 0.1);
    EXPECT_GT(dark, 1.1) << thickness;
    EXPECT_LT(dark, 1.2) << thickness;
    EXPECT_LT(through(isotropic, 0.01) / through(forwards, 0.01), 1.05) << thickness;
  }
}

TEST(LateralStack, InterpolatesWhatLayersAnswer) {
  LateralMedium medium{stack_index, 0.9};
  medium.cover = LateralCover{{0.3, 2.0}, 0.1};
  const LateralStack stack(medium);
  const LayeredTransport transport(stack_index, 0.9);
  for (const double mua : {0.011, 0.07}) {
    for (const double f : {0.0, 0.1, 0.25}) {
      const auto exact = [&](double a, double s) {
        const std::array<TransportLayer, 2> layers{{{0.3, 2.0, 0.1}, {a, s, endless}}};
        return transport(layers, f).reflectance;
      };
      const LateralValue found = stack.reflectance(f, mua, 1.3);
      EXPECT_NEAR(found.reflectance / exact(mua, 1.3), 1.0, 2e-4) << mua << " " << f;
      constexpr double part = 1e-3;
      const double by_mua =
          (exact(mua * (1.0 + part), 1.3) - exact(mua * (1.0 - part), 1.3)) / (2.0 * part * mua);
      const double by_musp =
          (exact(mua, 1.3 * (1.0 + part)) - exact(mua, 1.3 * (1.0 - part))) / (2.0 * part * 1.3);
      EXPECT_NEAR(found.d_mua / by_mua, 1.0, 0.02);
      EXPECT_NEAR(found.d_musp / by_musp, 1.0, 0.02);
    }
  }
}

}  // namespace
}  // namespace kappamu::forward
