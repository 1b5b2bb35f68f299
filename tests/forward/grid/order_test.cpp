// Convergence of the grid solvers towards the continuous equations: order 2 on manufactured
// solutions and on a closed form.
#include <gtest/gtest.h>

#include <cmath>

#include "forward/grid/grid_physics.h"
#include "tests/forward/analytic/slab.h"
#include "tests/forward/grid/backends.h"
#include "tests/forward/grid/test_tools.h"

namespace kappamu::forward {
namespace {

using testing::Values;

/// Theory says 2; the coarsest pair of grids is not quite asymptotic.
constexpr double order = 2.0, order_band = 0.15;

class GridOrder : public testing::OnBackend {
 protected:
  /// log2 of the ratio of successive errors.
  static void expect_order(const std::vector<double>& errors) {
    for (std::size_t i = 1; i < errors.size(); ++i) {
      EXPECT_NEAR(std::log2(errors[i - 1] / errors[i]), order, order_band)
          << "errors " << errors[i - 1] << " then " << errors[i];
    }
  }
  static SolveOptions tight() { return {single() ? 1e-7 : 1e-11, 300}; }
};

/// Smooth κ, μ and φ without symmetry, in units of a block of 2 x 3 x 1.5 mm.
struct Manufactured {
  static double kappa(double x, double y, double z) {
    return 0.3 + 0.1 * std::sin(1.1 * x + 0.3) * std::cos(0.8 * y) + 0.05 * std::cos(1.7 * z);
  }
  static double mu(double x, double y, double z) {
    return 0.2 + 0.1 * std::cos(0.9 * x) * std::sin(0.7 * y + 0.2 + z);
  }
  static double phi(double x, double y, double z) {
    return 2.0 + std::cos(1.3 * x + 0.4) * std::sin(0.9 * y + 0.5) * std::cos(1.1 * z + 0.2);
  }
};

/// Central differences of such smooth functions at this step are exact to 1e-8, far below any
/// discretisation error here.
constexpr double step = 1e-4;

double flux(int axis, double x, double y, double z) {  // κ ∂φ/∂axis
  std::array<double, 3> plus{x, y, z}, minus{x, y, z};
  plus[static_cast<std::size_t>(axis)] += step;
  minus[static_cast<std::size_t>(axis)] -= step;
  return Manufactured::kappa(x, y, z) *
         (Manufactured::phi(plus[0], plus[1], plus[2]) -
          Manufactured::phi(minus[0], minus[1], minus[2])) /
         (2 * step);
}

TEST_P(GridOrder, ManufacturedSolutionWithRobinFaces) {
  std::vector<double> errors;
  for (const int n : {1, 2, 4}) {
    const GridShape shape{8 * n, 12 * n, 6 * n, 0.25 / n};
    const double h = shape.voxel_mm;
    const auto s = solver({.shape = shape});
    Values kappa(shape.cells()), mu(shape.cells()), exact(shape.cells()), rhs(shape.cells());
    const auto centre = [&](int i) { return (i + 0.5) * h; };
    for (int k = 0; k < shape.nz; ++k) {
      for (int j = 0; j < shape.ny; ++j) {
        for (int i = 0; i < shape.nx; ++i) {
          const double x = centre(i), y = centre(j), z = centre(k);
          const std::size_t c = shape.index(i, j, k);
          kappa[c] = Manufactured::kappa(x, y, z);
          mu[c] = Manufactured::mu(x, y, z);
          exact[c] = Manufactured::phi(x, y, z);
          const double divergence =
              (flux(0, x + step, y, z) - flux(0, x - step, y, z) + flux(1, x, y + step, z) -
               flux(1, x, y - step, z) + flux(2, x, y, z + step) - flux(2, x, y, z - step)) /
              (2 * step);
          rhs[c] = (mu[c] * exact[c] - divergence) * h * h * h;
        }
      }
    }
    // q = φ + 2Aκ ∂φ/∂n enters each face as it does under the boundary source, G_b q.
    const double two_a = 2 * s->constants().A;
    for (const Face face : all_faces) {
      const FaceShape size = face_shape(shape, face);
      const int axis = axis_of(face);
      const double side = is_plus(face) ? shape.extent(axis) * h : 0.0;
      const double sign = is_plus(face) ? 1.0 : -1.0;
      for (int v = 0; v < size.nv; ++v) {
        for (int u = 0; u < size.nu; ++u) {
          const double a = centre(u), b = centre(v);
          const double x = axis == 0 ? side : a;
          const double y = axis == 0 ? a : axis == 1 ? side : b;
          const double z = axis == 2 ? side : b;
          const double q = Manufactured::phi(x, y, z) + two_a * sign * flux(axis, x, y, z);
          const std::size_t c = face_cell(shape, face, u, v);
          rhs[c] += q * h * h / (h / (2 * kappa[c]) + two_a);
        }
      }
    }
    s->set_medium(kappa, mu);
    const auto solution = testing::solve_rhs(*s, rhs, 1, tight());
    ASSERT_EQ(solution.report.termination, Termination::converged) << solution.report.message;
    errors.push_back(testing::relative_difference(testing::read(*s, *solution.phi), exact));
  }
  expect_order(errors);
}

/// Mirror sides make the block a slab of infinite width: every column is the closed form.
TEST_P(GridOrder, MirrorSidesAreASlab) {
  const Slab slab{0.12, 0.02, 3.0};
  constexpr double E = 0.8;
  for (const SourceModel source : {SourceModel::first_collision, SourceModel::boundary}) {
    for (const Face lit : {Face::z_minus, Face::x_plus}) {
      std::vector<double> errors, far_errors;
      for (const int n : {24, 48, 96}) {
        const GridShape shape = lit == Face::z_minus ? GridShape{2, 3, n, slab.thickness / n}
                                                     : GridShape{n, 2, 3, slab.thickness / n};
        const auto s =
            solver({.shape = shape, .lit_face = lit, .sides = Sides::mirror, .source = source});
        s->set_medium(Values(shape.cells(), slab.kappa), Values(shape.cells(), slab.mu));
        const SlabFluence exact = source == SourceModel::boundary
                                      ? slab_boundary(slab, s->constants(), E)
                                      : slab_first_collision(slab, s->constants(), E);
        const auto solution = testing::solve_light(*s, Values(6, E), 1, tight());
        const Values phi = testing::read(*s, *solution.phi);
        Values expected(phi.size());
        for (int w = 0; w < n; ++w) {
          for (int k = 0; k < 6; ++k) {
            expected[face_cell(shape, lit, k % 2, k / 2, w)] =
                exact.mean(w * shape.voxel_mm, (w + 1) * shape.voxel_mm);
          }
        }
        errors.push_back(testing::relative_difference(phi, expected));
        const double far = testing::exitance(*s, *solution.phi, opposite(lit), {})[4];
        far_errors.push_back(std::abs(far - exact.exitance_far()));
      }
      expect_order(errors);
      expect_order(far_errors);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, GridOrder,
                         ::testing::Values(testing::reference_backend, testing::opencl_single,
                                           testing::opencl_double),
                         testing::backend_name);

}  // namespace
}  // namespace kappamu::forward
