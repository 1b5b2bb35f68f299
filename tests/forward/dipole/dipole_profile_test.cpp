// BSSRDF profiles: closed forms, totals, symmetry. What they are worth against transport is in
// docs/dipole.md.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.h"
#include "forward/dipole/profile/profile.h"
#include "tests/forward/analytic/half_space.h"

namespace kappamu::forward::dipole {
namespace {

constexpr double eta = 1.3;
/// Jensen et al. 2001: σs' 2.19, σa 0.0021 per mm.
const Material marble{1.0 / (3.0 * 2.1921), 0.0021};
/// α' = 0.9.
const Material dark{0.5, 0.2 / 3.0};
constexpr double rounding = 1e-12;

class Profiles : public testing::TestWithParam<const char*> {};

TEST_P(Profiles, TotalIsTheIntegralOverThePlane) {
  for (const Material& m : {marble, dark}) {
    const Profile profile = make_profile(GetParam(), m, eta);
    // r = e^y, midpoint rule: R_d r² falls off on either side.
    double sum = 0.0;
    constexpr double step = 0.02;
    for (double y = -14.0; y < 7.0; y += step) {
      const double r = std::exp(y + 0.5 * step);
      sum += step * 2.0 * std::numbers::pi * r * r * profile.value(r);
    }
    EXPECT_NEAR(sum / profile.reflectance(), 1.0, 1e-5);
    EXPECT_GT(profile.reflectance(), 0.0);
    EXPECT_LT(profile.reflectance(), 1.0);
  }
}

TEST_P(Profiles, DerivativesAreThoseOfTheValue) {
  const Profile profile = make_profile(GetParam(), dark, eta);
  for (const double r : {0.3, 1.0, 4.0}) {
    constexpr double step = 1e-5, differences = 1e-7;
    const auto at = [&](double x) { return profile.derivatives(x); };
    const double first = (at(r + step).value - at(r - step).value) / (2.0 * step * r);
    const double second = (at(r + step).first - at(r - step).first) / (2.0 * step * r);
    EXPECT_NEAR(at(r).first / first, 1.0, differences);
    EXPECT_NEAR(at(r).second / second, 1.0, differences);
    const double slope = (profile.beyond(r + step) - profile.beyond(r - step)) / (2.0 * step);
    EXPECT_NEAR(-at(r).value * r / slope, 1.0, differences);
  }
}

TEST_P(Profiles, WithoutAbsorptionIsTheLimitOfLittle) {
  const Profile none = make_profile(GetParam(), {0.2, 0.0}, eta);
  const Profile little = make_profile(GetParam(), {0.2, 1e-9}, eta);
  constexpr double limit = 1e-3;  // √μ
  EXPECT_NEAR(none.reflectance(), little.reflectance(), limit);
  EXPECT_NEAR(none.value(1.0) / little.value(1.0), 1.0, limit);
}

TEST_P(Profiles, ScaleWithTheUnitOfLength) {
  const Profile one = make_profile(GetParam(), dark, eta);
  const Profile ten = make_profile(GetParam(), {10.0 * dark.kappa, dark.mu / 10.0}, eta);
  EXPECT_NEAR(one.value(0.7) / (100.0 * ten.value(7.0)), 1.0, rounding);
  EXPECT_NEAR(one.reflectance() / ten.reflectance(), 1.0, rounding);
}

TEST_P(Profiles, AlignedIsTheSameOnThePlaneAndNotReciprocalElsewhere) {
  const Profile profile = make_profile(GetParam(), marble, eta);
  const Eigen::Vector3d a(0, 0, 0), flat(0.6, 0.8, 0), up(0, 0, 1);
  EXPECT_NEAR(profile.aligned_value(a, up, flat) / profile.value(1.0), 1.0, rounding);
  // A cube's edge: from the top face to a side face and back.
  const Eigen::Vector3d top(-0.5, 0, 0), side(0, 0, -0.3), out(1, 0, 0);
  EXPECT_GT(
      std::abs(profile.aligned_value(top, up, side) / profile.aligned_value(side, out, top) - 1.0),
      0.05);
}

INSTANTIATE_TEST_SUITE_P(All, Profiles,
                         testing::Values("dipole", "better-dipole", "beam-diffusion"));

TEST(Profile, OfTheDipoleIsTheHalfSpacesClosedForm) {
  const BoundaryConstants constants = boundary_constants(eta);
  for (const Material& m : {marble, dark}) {
    const Profile profile = classical_dipole(m, constants.A);
    const double t = constants.normal_transmittance;
    for (const double r : {0.1, 1.0, 5.0}) {
      EXPECT_NEAR(t * profile.value(r) / dipole_exitance(m, constants, BeamSource::one_depth, r),
                  1.0, rounding);
    }
    EXPECT_NEAR(t * profile.reflectance() / dipole_reflectance(m, constants, BeamSource::one_depth),
                1.0, rounding);
  }
}

/// Diffuse reflectance of a half-space of isotropic scatterers for light along the normal, without
/// reflection at the surface: 1 − H(1)√(1−α), 1/H(c) = √(1−α) + α/2 ∫ c'H(c')/(c + c') dc'
/// (Chandrasekhar, Radiative Transfer, 1960).
double exact_reflectance(double albedo) {
  constexpr int n = 400;
  const double root = std::sqrt(1.0 - albedo);
  const auto next = [&](const std::vector<double>& h, double c) {
    double sum = 0.0;
    for (int j = 0; j < n; ++j) {
      const double at = (j + 0.5) / n;
      sum += at * h[static_cast<std::size_t>(j)] / (c + at) / n;
    }
    return 1.0 / (root + 0.5 * albedo * sum);
  };
  std::vector<double> h(n, 1.0);
  for (int sweep = 0; sweep < 60; ++sweep) {
    const std::vector<double> before = h;
    for (int i = 0; i < n; ++i) {
      auto& value = h[static_cast<std::size_t>(i)];
      value = 0.5 * (value + next(before, (i + 0.5) / n));
    }
  }
  return 1.0 - next(h, 1.0) * root;
}

// What d'Eon and Habel model is light scattered more than once; they add single scattering,
// α/2 (1 − ln 2), apart. The classical dipole stands for both.
TEST(Profile, OfMultipleScatteringTheBetterOnesAreNearerToTransport) {
  for (const double albedo : {0.5, 0.8, 0.9, 0.99}) {
    const Material m{1.0 / 3.0, 1.0 - albedo};
    const double exact = exact_reflectance(albedo);
    const double multiple = exact - 0.5 * albedo * (1.0 - std::numbers::ln2);
    const auto error = [&](const char* name, double of) {
      return std::abs(make_profile(name, m, 1.0).reflectance() / of - 1.0);
    };
    EXPECT_LT(error("better-dipole", multiple), 0.25);
    EXPECT_LT(error("better-dipole", multiple), error("dipole", multiple));
    EXPECT_LT(error("dipole", exact), 0.8 * (1.0 - albedo));
    EXPECT_LT(error("dipole", exact), error("better-dipole", exact));
  }
}

TEST(Profile, RefusesWhatIsNoMedium) {
  EXPECT_THROW(make_profile("dipole", {0.0, 0.1}, eta), InputError);
  EXPECT_THROW(make_profile("dipole", {0.5, 0.7}, eta), InputError);
  EXPECT_THROW(make_profile("tripole", marble, eta), InputError);
}

}  // namespace
}  // namespace kappamu::forward::dipole
