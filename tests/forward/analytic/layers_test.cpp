// Layered stacks and half-spaces in closed form: against their own equations, each other and the
// slab. The block of layers against the grid solvers is in analytic_block_test.cpp.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/error.h"
#include "forward/analytic/layered_mode.h"
#include "tests/forward/analytic/half_space.h"
#include "tests/forward/analytic/slab.h"

namespace kappamu::forward {
namespace {

constexpr double rounding = 1e-11;
constexpr double infinite = std::numeric_limits<double>::infinity();
const BoundaryConstants constants = boundary_constants(1.3);
const std::vector<Layer> three{{0.12, 0.02, 0.7}, {0.5, 0.3, 0.4}, {0.05, 0.0, 1.1}};

TEST(LayeredMode, OneLayerIsTheSlab) {
  const Slab slab{0.15, 0.03, 2.5};
  const std::vector<Layer> whole{{slab.kappa, slab.mu, slab.thickness}};
  const double T = constants.normal_transmittance, q = 4 * T / (1 - constants.r_phi);
  const SlabFluence beam = slab_first_collision(slab, constants, 1.0);
  const SlabFluence diffuse = slab_boundary(slab, constants, 1.0);
  const LayeredMode ours_beam(whole, constants.A, {0.0, T, 0.0, 1.0 - T});
  const LayeredMode ours_diffuse(whole, constants.A, {0.0, 0.0, q});
  for (const double z : {0.0, 0.01, 0.8, 2.49, 2.5}) {
    EXPECT_NEAR(ours_beam.fluence(z), beam(z), rounding) << z;
    EXPECT_NEAR(ours_diffuse.fluence(z), diffuse(z), rounding) << z;
  }
  EXPECT_NEAR(ours_beam.flux_out_near(), beam.exitance_near(), rounding);
  EXPECT_NEAR(ours_beam.flux_out_far(), beam.exitance_far(), rounding);
  EXPECT_NEAR(ours_diffuse.flux_out_near(), diffuse.exitance_near(), rounding);
}

TEST(LayeredMode, CuttingLayersChangesNothing) {
  const ModeSource source{3.0, 0.9, 0.4, 0.3};
  const std::vector<Layer> cut{{0.12, 0.02, 0.3}, {0.12, 0.02, 1e-6}, {0.12, 0.02, 0.399999},
                               {0.5, 0.3, 0.4},   {0.05, 0.0, 1.0},   {0.05, 0.0, 0.1}};
  const LayeredMode a(three, constants.A, source), b(cut, constants.A, source);
  for (const double z : {0.0, 0.3, 0.65, 1.0, 1.9, 2.2}) {
    // A slice of 1 nm holds fluxes as differences of values 1e-7 apart.
    EXPECT_NEAR(a.fluence(z), b.fluence(z), 1e-9) << z;
  }
  EXPECT_NEAR(a.unscattered_near(), b.unscattered_near(), rounding);
  EXPECT_NEAR(a.unscattered_far(), b.unscattered_far(), rounding);
  EXPECT_NEAR(a.scattered(), b.scattered(), rounding);
}

/// κφ'' − (μ + κk²)φ + S = 0 inside every layer, by central differences, at the resonance γ =
/// 1/(3κ) too; and the conditions between layers and at both surfaces, by one-sided ones.
TEST(LayeredMode, SatisfiesItsEquations) {
  const double resonant_kappa = 0.2;
  std::vector<Layer> layers = three;
  layers.push_back({resonant_kappa, 1 / (9 * resonant_kappa), 0.6});
  for (const double k2 : {0.0, 2.5}) {
    const double beam = 0.8, q = 0.3, reflectance = 0.4;
    const LayeredMode mode(layers, constants.A, {k2, beam, q, reflectance});
    double depth = 0.0;
    for (const Layer& layer : layers) depth += layer.thickness / (3 * layer.kappa);
    const double round_trip = reflectance * std::exp(-depth);
    double power = beam / (1 - round_trip * round_trip);
    double returned = power * reflectance * std::exp(-2 * depth);  // at the layer's top
    double top = 0.0;
    double flux_above = (q - mode.fluence(0.0)) / (2 * constants.A);  // along +z
    for (const Layer& layer : layers) {
      const double extinction = 1 / (3 * layer.kappa), h = 1e-3 * layer.thickness;
      const auto phi = [&](double z) { return mode.fluence(top + z); };
      for (const double part : {0.1, 0.5, 0.9}) {
        const double z = part * layer.thickness;
        const double curvature = (phi(z + h) - 2 * phi(z) + phi(z - h)) / (h * h);
        const double source =
            std::max(0.0, extinction - layer.mu) *
            (power * std::exp(-extinction * z) + returned * std::exp(extinction * z));
        const double sink = (layer.mu + layer.kappa * k2) * phi(z);
        // Central differences at this step.
        EXPECT_NEAR(layer.kappa * curvature + source, sink, 2e-4 * (source + sink)) << top + z;
      }
      const double d = layer.thickness;
      const double entering = -layer.kappa * (-3 * phi(0) + 4 * phi(h) - phi(2 * h)) / (2 * h);
      const double leaving =
          layer.kappa * (-3 * phi(d) + 4 * phi(d - h) - phi(d - 2 * h)) / (2 * h);
      EXPECT_NEAR(entering, flux_above, 1e-4);
      flux_above = leaving;
      power *= std::exp(-extinction * d);
      returned *= std::exp(extinction * d);
      top += d;
    }
    EXPECT_NEAR(flux_above, mode.flux_out_far(), 1e-4);
    EXPECT_NEAR(mode.flux_out_far(), mode.fluence(top) / (2 * constants.A), rounding);
  }
}

TEST(LayeredMode, ConservesPower) {
  const LayeredMode mode(three, constants.A, {0.0, 1.0, 0.0, 0.2});
  double top = 0.0, absorbed = 0.0;
  constexpr int n = 4000;
  for (const Layer& layer : three) {
    for (int i = 0; i < n; ++i) {
      absorbed +=
          layer.mu * layer.thickness / n * mode.fluence(top + layer.thickness * (i + 0.5) / n);
    }
    top += layer.thickness;
  }
  EXPECT_NEAR(mode.flux_out_near() + mode.flux_out_far() + absorbed, mode.scattered(),
              1e-6);  // midpoint rule
  // Without absorption the beam alone: what does not scatter leaves.
  const std::vector<Layer> clear{{0.12, 0.0, 0.7}, {0.5, 0.0, 0.4}};
  const LayeredMode beam(clear, constants.A, {0.0, 1.0, 0.0, 0.2});
  EXPECT_NEAR(beam.scattered() + beam.unscattered_near() + beam.unscattered_far(), 1.0, rounding);
}

/// Light sent in at one side and seen at the other: the same the other way round.
TEST(LayeredMode, IsReciprocal) {
  const std::vector<Layer> turned(three.rbegin(), three.rend());
  for (const double k2 : {0.0, 1.0, 100.0}) {
    const double there = LayeredMode(three, constants.A, {k2, 0.0, 1.0}).flux_out_far();
    const double back = LayeredMode(turned, constants.A, {k2, 0.0, 1.0}).flux_out_far();
    EXPECT_NEAR(there, back, rounding * there) << k2;
  }
}

/// Without absorption and at the highest frequencies nothing overflows or loses its digits.
TEST(LayeredMode, HoldsAtTheExtremes) {
  const std::vector<Layer> clear{{0.1, 0.0, 5.0}};
  const LayeredMode even(clear, constants.A, {0.0, 1.0, 0.0});
  EXPECT_NEAR(even.flux_out_near() + even.flux_out_far(), even.scattered(), 1e-9);
  const LayeredMode fine(three, constants.A, {1e12, 1.0, 0.0});
  EXPECT_GT(fine.flux_out_far(), 0.0);  // what the beam deposits there, unblurred
  EXPECT_LT(fine.flux_out_far(), fine.flux_out_near());
  EXPECT_LT(fine.flux_out_near(), 1e-9);
}

TEST(LayeredMode, RefusesWhatIsNoStack) {
  const auto build = [](const std::vector<Layer>& layers) {
    return LayeredMode(layers, constants.A, {});
  };
  EXPECT_THROW(build({}), InputError);
  EXPECT_THROW(build({{0.1, -0.1, 1.0}}), InputError);
  EXPECT_THROW(build({{0.1, 0.1, infinite}, {0.1, 0.1, 1.0}}), InputError);
}

const Material marble{0.1, 0.004};

/// Every photon leaves a sphere around the source or is absorbed in it.
TEST(PointSource, ConservesPower) {
  for (const double radius : {0.1, 2.0, 10.0}) {
    double absorbed = 0.0;
    constexpr int n = 20000;
    for (int i = 0; i < n; ++i) {
      const double r = radius * (i + 0.5) / n;
      absorbed +=
          marble.mu * point_source_fluence(marble, r) * 4 * std::numbers::pi * r * r * radius / n;
    }
    const double leaving =
        4 * std::numbers::pi * radius * radius * point_source_flux(marble, radius);
    EXPECT_NEAR(leaving + absorbed, 1.0, 1e-8) << radius;  // midpoint rule
  }
}

TEST(Dipole, TotalIsTheIntegralOfTheExitance) {
  for (const BeamSource source : {BeamSource::one_depth, BeamSource::first_collision}) {
    double sum = 0.0;
    constexpr int n = 4000;
    constexpr double low = -14.0, high = 6.0;  // ln r: 1 µm to 400 mm
    for (int i = 0; i < n; ++i) {
      const double r = std::exp(low + (high - low) * (i + 0.5) / n);
      sum += dipole_exitance(marble, constants, source, r) * 2 * std::numbers::pi * r * r *
             (high - low) / n;
    }
    const double total = dipole_reflectance(marble, constants, source);
    EXPECT_NEAR(sum, total, 1e-5 * total);  // what the range and the rule leave out
  }
}

/// Images about z = −2Aκ are the Robin condition but for (2Aκμ_eff)³/3.
TEST(Dipole, ApproachesTheExactHalfSpaceAsAbsorptionFalls) {
  std::vector<double> differences;
  for (const double mu : {4e-3, 1e-3}) {
    const Material m{0.1, mu};
    differences.push_back(dipole_reflectance(m, constants, BeamSource::first_collision) /
                              half_space_reflectance(m, constants) -
                          1.0);
  }
  const double small = 2 * constants.A * 0.1 * std::sqrt(4e-3 / 0.1);
  EXPECT_LT(std::abs(differences[0]), small * small * small);
  EXPECT_NEAR(differences[0] / differences[1], 8.0, 0.5);  // μ_eff was halved
}

TEST(HalfSpace, IsTheInfinitelyThickLayerAndTheThickSlab) {
  const double T = constants.normal_transmittance;
  const double R = half_space_reflectance(marble, constants);
  const std::vector<Layer> infinite_layer{{marble.kappa, marble.mu, infinite}};
  const LayeredMode layered(infinite_layer, constants.A, {0.0, T, 0.0});
  EXPECT_NEAR(layered.flux_out_near(), R, rounding);
  EXPECT_EQ(layered.flux_out_far(), 0.0);
  const SlabFluence slab = slab_first_collision({marble.kappa, marble.mu, 100.0}, constants, 1.0);
  EXPECT_NEAR(slab.exitance_near(), R, 1e-8);  // e^(−2μ_eff L) is left
  EXPECT_NEAR(layered.fluence(1.5), slab(1.5), 1e-8);
}

TEST(HalfSpace, RefusesMediaWithoutScattering) {
  EXPECT_THROW(half_space_reflectance({0.1, 4.0}, constants), InputError);
  EXPECT_THROW(point_source_fluence({0.0, 0.1}, 1.0), InputError);
}

}  // namespace
}  // namespace kappamu::forward
