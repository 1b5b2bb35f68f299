// The closed form against its own equations.
#include "tests/forward/analytic/slab.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"

namespace kappamu::forward {
namespace {

constexpr double rounding = 1e-12;
const Slab slab{0.15, 0.03, 2.5};

TEST(Slab, SatisfiesBothBoundaryConditions) {
  const BoundaryConstants c = boundary_constants(1.3);
  const double two_a_kappa = 2 * c.A * slab.kappa;
  const SlabFluence beam = slab_first_collision(slab, c, 1.0);
  EXPECT_NEAR(beam(0) - two_a_kappa * beam.derivative(0), 0.0, rounding);
  EXPECT_NEAR(beam(2.5) + two_a_kappa * beam.derivative(2.5), 0.0, rounding);
  const SlabFluence diffuse = slab_boundary(slab, c, 1.0);
  EXPECT_NEAR(diffuse(0) - two_a_kappa * diffuse.derivative(0),
              4 * c.normal_transmittance / (1 - c.r_phi), rounding);
  EXPECT_NEAR(diffuse(2.5) + two_a_kappa * diffuse.derivative(2.5), 0.0, rounding);
}

/// What enters leaves or is absorbed: the beam's part by its own integrals.
TEST(Slab, ConservesPower) {
  const BoundaryConstants c = boundary_constants(1.3);
  const SlabFluence beam = slab_first_collision(slab, c, 1.0);
  const double l = 3 * slab.kappa;
  const double R = 1 - c.normal_transmittance, passes = std::exp(-slab.thickness / l);
  // Of what passes, R goes back, and so on: (1 − R) p/(1 − R p) leaves.
  const double scattered =
      c.normal_transmittance * (1 - l * slab.mu) * (1 - (1 - R) * passes / (1 - R * passes));
  const double absorbed = slab.mu * slab.thickness * beam.mean(0, slab.thickness);
  EXPECT_NEAR(beam.exitance_near() + beam.exitance_far() + absorbed, scattered, rounding);
}

TEST(Slab, MeanIsTheIntegralOfTheFluence) {
  const SlabFluence beam = slab_first_collision(slab, boundary_constants(1.3), 1.0);
  constexpr int n = 20000;
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += beam(0.5 + (i + 0.5) / n);
  // The midpoint rule's own error is of order 1/n².
  EXPECT_NEAR(sum / n, beam.mean(0.5, 1.5), 1e-8);
}

TEST(Slab, RefusesWhatHasNoClosedForm) {
  const BoundaryConstants c = boundary_constants(1.3);
  EXPECT_THROW(slab_boundary({0.15, 0.0, 1.0}, c, 1.0), InputError);
  EXPECT_THROW(slab_first_collision({0.1, 1 / 0.9, 1.0}, c, 1.0), InputError);
}

}  // namespace
}  // namespace kappamu::forward
