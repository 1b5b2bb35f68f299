// [W] equation (8), ∇²(κφ) in place of ∇·(κ∇φ): the same for constant κ, and otherwise a different
// physics. Written in κφ it telescopes, so its totals balance; power goes astray inside.
#include <gtest/gtest.h>

#include <cmath>

#include "forward/grid/grid_physics.h"
#include "studies/baseline/stencil.h"
#include "tests/studies/baseline/tools.h"

namespace kappamu::forward::testing {
namespace {

/// The dense solution x of the stencil's equations by Gauß elimination: small grids only.
Values solve_dense(const baseline::Stencil& s, Values b) {
  const auto n = b.size();
  const int nx = s.n[0], ny = s.n[1];
  std::vector<Values> a(n, Values(n, 0.0));
  for (std::size_t i = 0; i < n; ++i) {
    a[i][i] = 1.0 / s.inverse[i];
    const int x = static_cast<int>(i) % nx, row = static_cast<int>(i) / nx, z = row / ny;
    const auto link = [&](bool exists, double g, std::size_t j) {
      if (exists) a[i][j] = a[j][i] = -g;
    };
    const auto at = [](int k) { return static_cast<std::size_t>(k); };
    const int cell = static_cast<int>(i);
    link(x + 1 < nx, s.face[0][at(cell + row + 1)], i + 1);
    link(row % ny + 1 < ny, s.face[1][at(cell + nx * (z + 1))], i + at(nx));
    link(z + 1 < s.n[2], s.face[2][at(cell + nx * ny)], i + at(nx * ny));
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return b;
}

/// φ of stencil (8) for b.
Values wang2008_fluence(const GridSetup& setup, const Coefficients& c, const Values& b) {
  Values phi =
      solve_dense(baseline::wang2008_stencil(setup, constants_of(setup).A, c.kappa, c.mu), b);
  for (std::size_t i = 0; i < phi.size(); ++i) phi[i] /= c.kappa[i];
  return phi;
}

constexpr double rounding = 1e-9;  // of eliminating a hundred unknowns of condition below 1e4

TEST(Wang2008Stencil, IsOursForConstantKappa) {
  for (const double kappa : {0.05, 0.3, 4.0}) {
    const GridSetup setup{{5, 4, 3, 0.4}};
    const Values constant(setup.shape.cells(), kappa);
    const Values mu = random_values(setup.shape.cells(), 0.0, 0.05, 3);
    const double A = constants_of(setup).A;
    const baseline::Stencil theirs = baseline::wang2008_stencil(setup, A, constant, mu);
    const baseline::Stencil ours =
        baseline::conservative_stencil(setup, A, baseline::bricks_of(setup.shape), constant, mu);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t k = 0; k < ours.face[axis].size(); ++k) {
        EXPECT_NEAR(theirs.face[axis][k] * kappa, ours.face[axis][k], 1e-14);
      }
    }
  }
}

TEST(Wang2008Stencil, BreaksReciprocityByTheRatioOfKappa) {
  // Source and detector exchanged: equal for ours, κ_j/κ_i for (8), whose matrix is A diag(κ), A
  // symmetric.
  const GridSetup setup{{4, 3, 3, 0.4}};
  const std::size_t n = setup.shape.cells(), i = 5, j = 31;
  Coefficients c = random_medium(setup.shape, 100.0, 21);
  c.kappa[j] = 3.0 * c.kappa[i];
  Values at_i(n, 0.0), at_j(n, 0.0);
  at_i[i] = at_j[j] = 1.0;
  const double i_from_j = wang2008_fluence(setup, c, at_j)[i];
  const double j_from_i = wang2008_fluence(setup, c, at_i)[j];
  EXPECT_NEAR(i_from_j / j_from_i, 3.0, rounding);
}

/// Light of one strength from all sides on a block that absorbs nothing must fill it evenly.
double unevenness_in_even_light(double contrast) {
  const GridSetup setup{{5, 4, 4, 0.4}};
  Coefficients c = random_medium(setup.shape, contrast, 33);
  c.mu.assign(c.mu.size(), 0.0);
  Values b(setup.shape.cells(), 0.0);
  const double A = constants_of(setup).A, h = setup.shape.voxel_mm;
  for (const Face face : all_faces) {
    const FaceShape s = face_shape(setup.shape, face);
    for (int v = 0; v < s.nv; ++v) {
      for (int u = 0; u < s.nu; ++u) {
        const std::size_t k = face_cell(setup.shape, face, u, v);
        b[k] += h * h / (h / (2.0 * c.kappa[k]) + 2.0 * A);  // G_b q with q = 1
      }
    }
  }
  const Values phi = wang2008_fluence(setup, c, b);
  return relative_difference(phi, Values(phi.size(), 1.0));
}

TEST(Wang2008Stencil, InventsGradientsInEvenLight) {
  EXPECT_LT(unevenness_in_even_light(1.0), rounding);
  double last = 0.0;
  for (const double contrast : {1.1, 2.0, 10.0, 100.0}) {
    const double unevenness = unevenness_in_even_light(contrast);
    EXPECT_GT(unevenness, 1.5 * last) << "contrast " << contrast;
    EXPECT_GT(unevenness, 1e-3);
    last = unevenness;
  }
}

struct Energy {
  double total;  ///< |entering − leaving − absorbed| / entering
  double astray;  ///< ½ Σ |A φ − b| / Σ b, A of ∇·(κ∇φ) − μφ: made in some voxels, lost in others
};
Energy energy_of(const std::string& method, double contrast) {
  const ForwardProblem problem = random_problem({9, 8, 7, 0.4}, Face::z_minus, contrast, 1);
  const auto grid = make_reference_solver(problem.setup);
  grid->set_medium(problem.medium.kappa.values(), problem.medium.mu.values());
  const auto b = grid->make_field(1);
  grid->light_source(problem.irradiance, *b);
  const Values light = read(*grid, *b);
  Values phi;
  if (method == "ours") {
    phi = read(*grid, *solve_light(*grid, problem.irradiance, 1, {1e-12, 1000}).phi);
  } else {
    phi = wang2008_fluence(problem.setup,
                           {problem.medium.kappa.values(), problem.medium.mu.values()}, light);
  }
  const auto field = grid->make_field(1), power = grid->make_field(1);
  grid->fill(*field, phi);
  grid->apply(*field, *power);
  const Values out = read(*grid, *power);
  Energy energy{0.0, 0.0};
  double entering = 0.0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    energy.total += out[i] - light[i];
    energy.astray += 0.5 * std::abs(out[i] - light[i]);
    entering += light[i];
  }
  return {std::abs(energy.total) / entering, energy.astray / entering};
}

TEST(Wang2008Stencil, LosesAndMakesPowerInsideThoughItsTotalsBalance) {
  EXPECT_LT(energy_of("ours", 100.0).astray, rounding);
  EXPECT_LT(energy_of("(8)", 1.0).astray, rounding);
  double last = 0.0;
  for (const double contrast : {1.1, 2.0, 10.0, 100.0}) {
    const Energy energy = energy_of("(8)", contrast);
    EXPECT_LT(energy.total, rounding) << "contrast " << contrast;
    EXPECT_GT(energy.astray, last) << "contrast " << contrast;
    EXPECT_GT(energy.astray, 1e-3) << "contrast " << contrast;
    RecordProperty("astray_at_" + std::to_string(contrast), std::to_string(energy.astray));
    last = energy.astray;
  }
}

TEST(Wang2008Stencil, ModelSolvesItsOwnEquations) {
  if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  const ForwardProblem problem = random_problem({6, 5, 4, 0.4}, Face::x_minus, 100.0, 1);
  const auto grid = make_reference_solver(problem.setup);
  grid->set_medium(problem.medium.kappa.values(), problem.medium.mu.values());
  const auto b = grid->make_field(1);
  grid->light_source(problem.irradiance, *b);
  const Values phi = wang2008_fluence(
      problem.setup, {problem.medium.kappa.values(), problem.medium.mu.values()}, read(*grid, *b));
  const auto field = grid->make_field(1);
  grid->fill(*field, phi);
  for (const auto& [precision, bound] :
       {std::pair{Precision::double_precision, 1e-8}, {Precision::single_precision, 1e-4}}) {
    const double tolerance = bound / 100.0;  // the error exceeds the residual by the conditioning
    const ForwardResult found = solve("wang2008-stencil", problem, tolerance, precision);
    EXPECT_EQ(found.termination, Termination::converged) << found.message;
    const Values expected = exitance(*grid, *field, Face::x_plus, {});
    EXPECT_LT(relative_difference(found.exitance[1], expected), bound);
  }
}

}  // namespace
}  // namespace kappamu::forward::testing
