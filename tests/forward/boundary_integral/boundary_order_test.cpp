// Convergence to the exact sphere as 1/N, N panels: the faceted sphere's own error falls so too.
#include <gtest/gtest.h>

#include <cmath>

#include "forward/boundary_integral/boundary_solve.h"
#include "forward/boundary_integral/layer_sum.h"
#include "forward/light_entry.h"
#include "tests/forward/embedded/embedded_test_tools.h"
#include "tests/forward/embedded/exact_sphere.h"

namespace kappamu::forward::boundary_integral {
namespace {

using embedded::ExactSphere;

constexpr double eta = 1.3;
const Eigen::Vector3d centre(0.123, 0.2, -0.31);
const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 3).normalized();

/// Relative 2-norm error of φ at the centroids under diffuse light 1 + cos + P₂(cos).
double sphere_error(int splits, const Coefficients& medium) {
  const BoundaryConstants constants = boundary_constants(eta);
  const ExactSphere sphere{5.0, medium, constants.A};
  const TriangleMesh mesh = embedded::icosphere(sphere.radius, splits, centre);
  const Surface surface = surface_of(mesh);
  const auto rays = embedded::make_caster(mesh);
  const std::vector<double> light(3, 1.0);
  std::vector<double> terms;
  for (int l = 0; l < 3; ++l) {
    // Without absorption r^l P_l solves the equation.
    terms.push_back(medium.mu > 0.0
                        ? sphere.lit_from_outside(l)
                        : 1.0 / (1.0 + 2.0 * l * constants.A * medium.kappa / sphere.radius));
  }
  std::vector<ObjectLight> lights(1);
  Eigen::VectorXd exact(static_cast<Eigen::Index>(surface.size()));
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const double cosine = axis.dot((surface.position[t] - centre).normalized());
    lights[0].diffuse.push_back(ExactSphere::legendre_sum(light, cosine));
    exact[static_cast<Eigen::Index>(t)] = ExactSphere::legendre_sum(terms, cosine);
  }
  exact *= 4.0 * diffuse_transmittance(constants) / (1.0 - constants.r_phi);
  constexpr double solved = 1e-6;
  const BoundaryAnswer answer =
      solve_boundary({mesh, surface, *rays, ObjectMedium(medium), eta, lights}, constants,
                     panels_of(mesh), solved);
  EXPECT_TRUE(answer.converged);
  EXPECT_LE(answer.iterations, 12);
  return (answer.fluence[0] - exact).norm() / exact.norm();
}

class BoundaryOrder : public testing::TestWithParam<Coefficients> {};

TEST_P(BoundaryOrder, IsOneOverTheNumberOfPanels) {
  const double coarse = sphere_error(2, GetParam()), fine = sphere_error(4, GetParam());
  EXPECT_GE(std::log(coarse / fine) / std::log(16.0), 0.93) << coarse << " to " << fine;
}

INSTANTIATE_TEST_SUITE_P(Media, BoundaryOrder,
                         testing::Values(Coefficients{0.2, 0.02}, Coefficients{0.2, 0.0},
                                         Coefficients{0.2, 1e-9}, Coefficients{1.0, 0.3}));

TEST(BoundaryOrder, NoAbsorptionIsTheLimitOfLittle) {
  EXPECT_NEAR(sphere_error(3, {0.2, 0.0}), sphere_error(3, {0.2, 1e-12}), 1e-6);
}

}  // namespace
}  // namespace kappamu::forward::boundary_integral
