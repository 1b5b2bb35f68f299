// Form factors against adaptive quadrature over a random sweep, and the energy of thin cylinders
// ([T] 3.6.1).
#include "forward/dipole/form_factor/form_factor.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/optics.h"
#include "tests/cases/form_factor_case.h"
#include "tests/cases/form_factor_quadrature.h"

namespace kappamu::forward::dipole {
namespace {

using Triangle = std::array<Eigen::Vector3d, 3>;

constexpr double eta = 1.3;
constexpr std::uint64_t population = 1;  // docs/dipole.md reports another
constexpr int sweep = 150;

TEST(FormFactor, IsTheIntegralOverTheTriangle) {
  constexpr double tolerance = 1e-3;
  for (const char* name : {"dipole", "better-dipole"}) {
    for (std::uint64_t i = 0; i < sweep; ++i) {
      const test_cases::FormFactorCase c = test_cases::form_factor_case(population, i);
      const Profile profile = make_profile(name, c.material, eta);
      EXPECT_NEAR(form_factor(profile, c.triangle, c.point).value /
                      test_cases::quadrature_form_factor(profile, c.triangle, c.point),
                  1.0, tolerance)
          << name << " " << i;
    }
  }
}

TEST(FormFactor, WithAlignedSourcesIsTheIntegralToo) {
  constexpr double tolerance = 5e-3;
  for (std::uint64_t i = 0; i < sweep; ++i) {
    const test_cases::FormFactorCase c = test_cases::form_factor_case(population, i);
    const Profile profile = make_profile("dipole", c.material, eta);
    EXPECT_NEAR(aligned_form_factor(profile, c.triangle, c.point).value /
                    test_cases::quadrature_aligned_form_factor(profile, c.triangle, c.point),
                1.0, tolerance)
        << i;
  }
}

// [T] 3.19 converges with its criterion, though 2/5 is not enough for 1 % everywhere
// (docs/dipole.md has the sweep).
TEST(FormFactor, OfTheTaylorSeriesConvergesWithItsCriterion) {
  const auto worst = [](double ratio) {
    double largest = 0.0;
    for (std::uint64_t i = 0; i < sweep; ++i) {
      const test_cases::FormFactorCase c = test_cases::form_factor_case(population, i);
      if (c.on_edge) continue;
      const Profile profile = make_profile("dipole", c.material, eta);
      const double exact = form_factor(profile, c.triangle, c.point).value;
      const double found = taylor_form_factor(profile, c.triangle, c.point, ratio).value;
      largest = std::max(largest, std::abs(found - exact) / profile.reflectance());
    }
    return largest;
  };
  const double coarse = worst(0.4), fine = worst(0.1);
  EXPECT_LT(coarse, 0.02);
  EXPECT_LT(fine, coarse / 8.0);  // order 2: 16
}

TEST(FormFactor, OfAPolygonIsThatOfItsTriangles) {
  const Profile profile = make_profile("dipole", {0.15, 0.01}, 1.3);
  const std::array<Eigen::Vector3d, 4> quad{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(2, 0, 0),
                                            Eigen::Vector3d(3, 2, 0), Eigen::Vector3d(0, 1, 0)};
  const Triangle one{quad[0], quad[1], quad[2]}, two{quad[0], quad[2], quad[3]};
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(1, 0.5, 0), Eigen::Vector3d(5, 1, -0.4), Eigen::Vector3d(0, 0, 0)}) {
    const double whole = form_factor(profile, quad, point).value;
    EXPECT_NEAR(
        (form_factor(profile, one, point).value + form_factor(profile, two, point).value) / whole,
        1.0, 1e-3);
  }
}

// [T] 3.6.1: R_d over both discs of a marble cylinder of radius 12 mm as seen from the middle of
// the top; 1.126 at a height of 2 mm, 1.28 at 1 mm. A polygon of 720 edges is the disc.
TEST(FormFactor, ThinMarbleCylindersCreateEnergy) {
  constexpr double thesis_eta = 1.5, radius = 12.0;
  const Material marble{1.0 / (3.0 * 2.1921), 0.0021};
  const double fdr = fdr_polynomial(thesis_eta);
  const Profile profile = classical_dipole(marble, (1.0 + fdr) / (1.0 - fdr));
  const auto discs = [&](double height) {
    std::vector<Eigen::Vector3d> top, bottom;
    for (int i = 0; i < 720; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / 720.0;
      top.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
      bottom.emplace_back(top.back().x(), top.back().y(), -height);
    }
    const Eigen::Vector3d middle(0, 0, 0);
    return form_factor(profile, top, middle).value + form_factor(profile, bottom, middle).value;
  };
  EXPECT_NEAR(discs(2.0), 1.126, 0.001);
  EXPECT_NEAR(discs(1.0), 1.28, 0.005);
  EXPECT_LT(discs(40.0), 1.0);
}

}  // namespace
}  // namespace kappamu::forward::dipole
