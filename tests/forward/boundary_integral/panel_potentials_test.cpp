// Integrals over one panel against what they must be: adaptive quadrature, and Gauss's law.
#include "forward/boundary_integral/panels/panel_potentials.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/mesh/shapes.h"

namespace kappamu::forward::boundary_integral {
namespace {

/// Splits until panels are small beside their distance.
PanelPotentials by_quadrature(const Panel& panel, const Eigen::Vector3d& x, double decay) {
  PanelPotentials sum;
  if (panel.radius > 0.1 * (panel.centre - x).norm()) {
    for (const Panel& part : split(panel)) {
      const PanelPotentials add = by_quadrature(part, x, decay);
      sum.single_layer += add.single_layer;
      sum.double_layer += add.double_layer;
    }
    return sum;
  }
  for (const Eigen::Vector3d& y : rule_points(panel)) {
    const double r = (y - x).norm();
    const double g = std::exp(-decay * r) / (4.0 * M_PI * r) * panel.area / 3.0;
    sum.single_layer += g;
    sum.double_layer += (x - y).dot(panel.normal) * (1.0 + decay * r) / (r * r) * g;
  }
  return sum;
}

TEST(PanelPotentials, AgreeWithQuadratureForAnyShapeAndPlace) {
  // Every third panel is a sliver of aspect 1:100 or so; points from 0.02 to 5 radii away.
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  const auto random = [&] {
    return Eigen::Vector3d(normal(generator), normal(generator), normal(generator));
  };
  constexpr double quadrature = 2e-5;  // of the sums above
  for (int k = 0; k < 90; ++k) {
    std::array<Eigen::Vector3d, 3> corner{random(), random(), random()};
    if (k % 3 == 0) corner[2] = 0.5 * (corner[0] + corner[1]) + 0.02 * random();
    const Panel panel = make_panel(corner, 0);
    const double height = panel.radius * std::pow(10.0, -1.7 + 2.4 * k / 90.0);
    const Eigen::Vector3d along = 0.7 * random();
    const Eigen::Vector3d x = panel.centre + along - along.dot(panel.normal) * panel.normal +
                              (k % 2 == 0 ? height : -height) * panel.normal;
    for (const double decay : {0.0, 0.1 / panel.radius, 1.0 / panel.radius}) {
      const PanelPotentials exact = panel_potentials(panel, x, decay);
      const PanelPotentials sum = by_quadrature(panel, x, decay);
      EXPECT_NEAR(exact.single_layer, sum.single_layer, quadrature * sum.single_layer);
      EXPECT_NEAR(exact.double_layer, sum.double_layer, quadrature);
    }
  }
}

TEST(PanelPotentials, OfItselfIsTheIntegralOverAngles) {
  // From the centroid the single layer is (1/4πλ) ∫ (1 − e^−λρ(θ)) dθ, ρ the distance to the rim
  // ([T] 5.4), and the double layer's principal value is 0.
  const Panel panel = make_panel({{{0.0, 0.0, 0.0}, {3.0, 0.2, 0.0}, {0.4, 1.0, 0.0}}}, 0);
  for (const double decay : {0.05, 0.5, 2.0}) {
    double sum = 0.0;
    constexpr int angles = 400'000;
    for (int k = 0; k < angles; ++k) {
      const double theta = 2.0 * M_PI * (k + 0.5) / angles;
      const Eigen::Vector3d ray(std::cos(theta), std::sin(theta), 0.0);
      double rim = 1e300;
      for (std::size_t e = 0; e < 3; ++e) {
        const Eigen::Vector3d outward =
            (panel.corner[(e + 1) % 3] - panel.corner[e]).cross(panel.normal);
        const double speed = outward.dot(ray);
        if (speed > 0.0) {
          rim = std::min(rim, outward.dot(panel.corner[e] - panel.centre) / speed);
        }
      }
      sum += (1.0 - std::exp(-decay * rim)) / decay / angles / 2.0;
    }
    const PanelPotentials own = panel_potentials(panel, panel.centre, decay);
    EXPECT_NEAR(own.single_layer, sum, 1e-6 * sum);
    EXPECT_EQ(own.double_layer, 0.0);
  }
}

TEST(PanelPotentials, OfAClosedSurfaceObeyGausssLaw) {
  // ∫ ∂G/∂n dA is −1 inside and 0 outside; on a smooth part of the surface, −½.
  const std::vector<Panel> panels = panels_of(box_mesh({2.0, 3.0, 1.0}, 6));
  const auto sum = [&](const Eigen::Vector3d& x) {
    double total = 0.0;
    for (const Panel& panel : panels) total += panel_potentials(panel, x, 0.0).double_layer;
    return total;
  };
  constexpr double rounding = 1e-12;
  EXPECT_NEAR(sum({0.9, -1.4, 0.499999}), -1.0, rounding);
  EXPECT_NEAR(sum({0.9, -1.4, 0.500001}), 0.0, rounding);
  EXPECT_NEAR(sum(panels[5].centre), -0.5, rounding);
}

}  // namespace
}  // namespace kappamu::forward::boundary_integral
