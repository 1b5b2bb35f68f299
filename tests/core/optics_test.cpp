// Laws of the Fresnel moments and the boundary constants; published values at η = 1.3 (transport
// reference).
#include "core/optics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"

namespace kappamu {
namespace {

constexpr double quadrature_tolerance =
    1e-10;  // header promises 1e-12; leave room for the literals' digits

TEST(Fresnel, NormalIncidenceIsTheClosedForm) {
  for (const double eta : {1.0, 1.3, 1.5, 2.4}) {
    const double expected = std::pow((eta - 1.0) / (eta + 1.0), 2);
    EXPECT_NEAR(fresnel_internal(eta, 1.0), expected, 1e-15) << eta;
    EXPECT_NEAR(fresnel_external(eta, 1.0), expected, 1e-15) << eta;
  }
}

TEST(Fresnel, IsReciprocal) {
  const double eta = 1.3;
  for (double cos_outside = 0.05; cos_outside <= 1.0; cos_outside += 0.05) {
    const double cos_inside = std::sqrt(1.0 - (1.0 - cos_outside * cos_outside) / (eta * eta));
    EXPECT_NEAR(fresnel_internal(eta, cos_inside), fresnel_external(eta, cos_outside), 1e-13);
  }
}

TEST(Fresnel, TotallyReflectsBeyondTheCriticalAngle) {
  const double eta = 1.5;
  const double cos_critical = std::sqrt(1.0 - 1.0 / (eta * eta));
  EXPECT_EQ(fresnel_internal(eta, 0.99 * cos_critical), 1.0);
  EXPECT_LT(fresnel_internal(eta, 1.01 * cos_critical), 1.0);
}

TEST(BoundaryConstants, MatchTheTransportReference) {
  const BoundaryConstants c = boundary_constants(1.3);
  EXPECT_NEAR(c.r_phi, 0.44445670127690284, quadrature_tolerance);
  EXPECT_NEAR(c.r_j, 0.30026695936791425, quadrature_tolerance);
  EXPECT_NEAR(c.A, 2.3405321643813295, quadrature_tolerance);
  EXPECT_NEAR((1.0 + c.r_phi) / (1.0 - c.r_phi), 2.6000794260266513, quadrature_tolerance);
  EXPECT_NEAR(c.normal_transmittance, 1.0 - 0.0170132325141777, 1e-14);
}

TEST(BoundaryConstants, OfMatchedIndicesReflectNothing) {
  const BoundaryConstants c = boundary_constants(1.0);
  EXPECT_NEAR(c.r_phi, 0.0, 1e-15);
  EXPECT_NEAR(c.A, 1.0, 1e-15);
  EXPECT_NEAR(c.normal_transmittance, 1.0, 1e-15);
}

TEST(BoundaryConstants, RefuseAnIndexBelowOne) {
  EXPECT_THROW(boundary_constants(0.9), InputError);
}

TEST(FdrPolynomial, DiffersFromTheIntegralAsDocumented) {
  const double f = fdr_polynomial(1.3);
  EXPECT_NEAR((1.0 + f) / (1.0 - f), 2.6021, 5e-5);
}

// ∫ L cosθ dω over the outer hemisphere is the exitance: what the camera model must conserve.
TEST(RadiancePerExitance, IntegratesToOne) {
  for (const double eta : {1.0, 1.3, 1.5}) {
    const BoundaryConstants c = boundary_constants(eta);
    constexpr int steps = 20000;
    double flux = 0.0;
    for (int i = 0; i < steps; ++i) {
      const double cosine = (i + 0.5) / steps;
      flux += radiance_per_exitance(c, cosine) * 2.0 * std::numbers::pi * cosine / steps;
    }
    EXPECT_NEAR(flux, 1.0, 1e-5) << "eta "
                                 << eta;  // midpoint rule with a root singularity at grazing
  }
}

TEST(RadiancePerExitance, AlongTheNormalIsAsMonteCarloSaw) {
  const BoundaryConstants c = boundary_constants(1.3);
  EXPECT_NEAR(radiance_per_exitance(c, 1.0) * std::numbers::pi, 1.117,
              5e-4);  // Monte Carlo: 1.10 to 1.12
}

}  // namespace
}  // namespace kappamu
