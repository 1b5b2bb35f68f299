// A block solved off the grid by cut cubes and on the grid by finite volumes: same coefficients,
// same light, two discretisations.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/numbers/relative_difference.h"
#include "embedded_test_tools.h"
#include "forward/embedded/embedded_model.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward::embedded {
namespace {

constexpr double eta = 1.3;
constexpr int squares = 8;  ///< on the block's z faces, of 1 mm, along x and y
constexpr double depth = 4.0;
using Values = std::vector<double>;

/// Voxels of 1 mm.
Medium blocks() {
  const GridShape shape{squares, squares, 4, 1.0};
  Medium medium{Volume<double>(shape), Volume<double>(shape)};
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (std::size_t k = 0; k < shape.cells(); ++k) {
    medium.kappa[k] = 0.3 + 0.2 * uniform(generator);
    medium.mu[k] = 0.05 * uniform(generator);
  }
  return medium;
}

double irradiance(double x, double y) {
  return 1.0 + 0.8 * std::cos(0.5 * x) * std::sin(0.4 * y);
}

/// Exitance of the 1 mm squares of the lower and upper z face, [face][y][x].
Values on_grid(const Medium& medium, int finer) {
  GridSetup setup;
  setup.shape = medium.kappa.shape().refined(finer);
  setup.eta = eta;
  const GridShape& shape = setup.shape;
  Values kappa, mu, light;
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        kappa.push_back(medium.kappa(x / finer, y / finer, z / finer));
        mu.push_back(medium.mu(x / finer, y / finer, z / finer));
        if (z == 0) light.push_back(irradiance((x + 0.5) / finer, (y + 0.5) / finer));
      }
    }
  }
  const auto solver = make_reference_solver(setup);
  solver->set_medium(kappa, mu);
  const auto b = solver->make_field(1), phi = solver->make_field(1);
  solver->light_source(light, *b);
  SolveOptions options;
  options.tolerance = 1e-8;
  EXPECT_EQ(solver->solve(*b, *phi, options).termination, Termination::converged);
  Values result;
  for (const Face face : {Face::z_minus, Face::z_plus}) {
    Values out(light.size());
    solver->exitance(*phi, face, face == Face::z_minus ? light : Values(), out);
    Values coarse(squares * squares, 0.0);
    for (std::size_t k = 0; k < out.size(); ++k) {
      const std::size_t n = static_cast<std::size_t>(shape.nx), f = static_cast<std::size_t>(finer);
      coarse[k / n / f * squares + k % n / f] += out[k] / (finer * finer);
    }
    result.insert(result.end(), coarse.begin(), coarse.end());
  }
  return result;
}

/// Index in box() of the triangle of a z face at a point.
int triangle_at(bool upper, double x, double y) {
  const int u = static_cast<int>(x), v = static_cast<int>(y);
  return (4 + (upper ? 1 : 0)) * 2 * squares * squares + 2 * (u * squares + v) +
         (y - v > x - u ? 1 : 0);
}

TEST(EmbeddedGrid, ABlockOffTheGridAgreesWithTheGrid) {
  const Medium medium = blocks();
  const Values coarse = on_grid(medium, 2), fine = on_grid(medium, 4);
  const double grid_error = relative_difference(coarse, fine) / 3.0;  // order 2

  const TriangleMesh mesh = box({squares, squares, depth}, squares);
  const Surface surface = surface_of(mesh);
  const auto rays = make_caster(mesh);
  const ObjectMedium placed(std::make_shared<Medium>(medium), Eigen::Affine3d::Identity(),
                            Wrap::clamp);
  ObjectLight light;
  constexpr int beams = 64;
  for (int i = 0; i < beams; ++i) {
    for (int j = 0; j < beams; ++j) {
      // Off the squares' diagonals, where a point has no one triangle.
      const double spacing = static_cast<double>(squares) / beams;
      const double x = (i + 0.5) * spacing, y = (j + 0.49) * spacing;
      light.beams.push_back({triangle_at(false, x, y),
                             {x, y, 0.0},
                             Eigen::Vector3d::UnitZ(),
                             irradiance(x, y) * spacing * spacing});
    }
  }
  const std::vector<ObjectLight> lights{light};
  ObjectOptions options;
  options.tolerance = 0.01;
  Progress progress;
  const ObjectResult result =
      EmbeddedModel().solve({mesh, surface, *rays, placed, eta, lights}, options, progress);
  EXPECT_TRUE(result.converged) << result.message;
  Values mine;
  for (const bool upper : {false, true}) {
    for (int y = 0; y < squares; ++y) {
      for (int x = 0; x < squares; ++x) {
        const auto below = static_cast<std::size_t>(triangle_at(upper, x + 0.6, y + 0.4));
        const auto above = static_cast<std::size_t>(triangle_at(upper, x + 0.4, y + 0.6));
        mine.push_back((result.exitance[below] + result.exitance[above]) / 2.0);
      }
    }
  }
  EXPECT_LE(relative_difference(mine, fine), result.error_estimate[0] + grid_error)
      << "stated: " << result.error_estimate[0] << ", grid: " << grid_error;
}

}  // namespace
}  // namespace kappamu::forward::embedded
