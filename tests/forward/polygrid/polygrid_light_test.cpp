// Light into and out of a polygrid: beams, diffuse light, and what the triangles of a mesh get.
#include <gtest/gtest.h>

#include <random>

#include "../embedded/exact_sphere.h"
#include "core/mesh/shapes.h"
#include "core/mesh/surface_norm.h"
#include "forward/light_entry.h"
#include "forward/polygrid/beams.h"
#include "forward/polygrid/cell_walk.h"
#include "forward/polygrid/polygrid_diffusion.h"
#include "made_polygrid.h"
#include "tests/forward/lit_object.h"

namespace kappamu::forward::polygrid {
namespace {

using Eigen::Vector3d;
using embedded::ExactSphere;

constexpr double eta = 1.3, radius = 5.0;
constexpr Coefficients coefficients{0.2, 0.02};

/// A ball's mesh with lights, one channel.
struct Ball : LitObject {
  explicit Ball(int tessellation)
      : LitObject(sphere_mesh(radius, tessellation), ObjectMedium(coefficients)) {}

  PolygridAnswer solve(int n) const {
    PolygridDiffusion diffusion(ball_polygrid(n, radius), mesh, surface, eta, "auto");
    const ObjectMedium* const media[] = {&medium};
    diffusion.set_media(media);
    const ObjectProblem asked = problem();
    return diffusion.solve({&asked, 1}, {}).front();
  }
};

TEST(PolygridWalk, FindsTheCellOfAPoint) {
  const Polygrid grid = bent_polygrid({9, 6, 4});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0.02, 0.98);
  std::uniform_int_distribution<int> any(0, static_cast<int>(grid.cell.size()) - 1);
  for (int trial = 0; trial < 300; ++trial) {
    const int cell = any(random);
    const Vector3d local(uniform(random), uniform(random), uniform(random));
    Vector3d point = Vector3d::Zero();
    for (std::size_t c = 0; c < 8; ++c) {
      point +=
          shape_functions(local)[c] * grid.corner[static_cast<std::size_t>(
                                          grid.cell_corners[static_cast<std::size_t>(cell)][c])];
    }
    const CellPoint found = walk_to(grid, {any(random), Vector3d::Constant(0.5)}, point);
    EXPECT_EQ(found.cell, cell);
    EXPECT_LE((found.local - local).norm(), 1e-6);
  }
}

TEST(PolygridWalk, StaysOnTheBoundaryBeyondIt) {
  const Polygrid grid = box_polygrid({4, 4, 4}, {1, 1, 1});
  const CellPoint found = walk_to(grid, {0, Vector3d::Constant(0.5)}, {0.6, 0.9, 1.2});
  EXPECT_EQ(grid.cell[static_cast<std::size_t>(found.cell)], Eigen::Vector3i(2, 3, 3));
  EXPECT_NEAR((found.local - Vector3d(0.4, 0.6, 1.0)).norm(), 0.0, 1e-6);
}

TEST(PolygridBeams, ShareTheirPowerExactly) {
  Ball ball(16);
  const Polygrid grid = ball_polygrid(10, radius);
  const SurfaceMap map(grid, ball.mesh, ball.surface);
  const std::vector<Coefficients> of_cell(grid.cell.size(), coefficients);
  std::vector<double> load(grid.corner.size(), 0.0);
  ObjectBalance balance;
  add_beams(grid, map, ball.problem(), parallel_beams(ball.surface, Vector3d(1, 2, -2) / 3.0),
            of_cell, 1e-9, load, balance);
  double scattered = 0.0;
  for (const double l : load) scattered += l;
  EXPECT_GT(scattered, 0.9 * balance.entering);
  EXPECT_NEAR(scattered + balance.absorbed + balance.unscattered, balance.entering,
              1e-12 * balance.entering);
  // Of what collides, μ/σt' is absorbed.
  EXPECT_NEAR(balance.absorbed,
              3.0 * coefficients.kappa * coefficients.mu * (balance.entering - balance.unscattered),
              1e-12 * balance.entering);
}

// Depth of the first collisions below the surface: 1/σt' along a beam to the centre.
TEST(PolygridBeams, CollideAtTheirMeanDepth) {
  Ball ball(24);
  const Polygrid grid = ball_polygrid(16, radius);
  const SurfaceMap map(grid, ball.mesh, ball.surface);
  const std::vector<Coefficients> of_cell(grid.cell.size(), coefficients);
  ObjectLight light;
  const int triangle = 100;
  const Vector3d inward = -ball.surface.normal[triangle];
  light.beams.push_back({triangle, ball.surface.position[triangle], inward, 1.0});
  std::vector<double> load(grid.corner.size(), 0.0);
  ObjectBalance balance;
  add_beams(grid, map, ball.problem(), light, of_cell, 1e-9, load, balance);
  double power = 0.0, depth = 0.0;
  for (std::size_t i = 0; i < load.size(); ++i) {
    power += load[i];
    depth += load[i] * (grid.corner[i] - ball.surface.position[triangle]).dot(inward);
  }
  constexpr double off_surface = 0.01;  // of mesh and polygrid from each other, over the depth
  EXPECT_NEAR(depth / power, 3.0 * coefficients.kappa, off_surface * 3.0 * coefficients.kappa);
}

TEST(PolygridDiffusion, BalancesPower) {
  Ball ball(20);
  ball.lights = {parallel_beams(ball.surface, Vector3d(0, 0, -1)),
                 parallel_beams(ball.surface, Vector3d(2, 1, 2) / 3.0)};
  ball.lights.back().diffuse.assign(ball.surface.size(), 0.3);
  const PolygridAnswer answer = ball.solve(12);
  for (const ObjectBalance& balance : answer.balance) {
    EXPECT_NEAR(balance.exiting + balance.absorbed + balance.unscattered, balance.entering,
                10.0 * PolygridAccuracy{}.linear_tolerance * balance.entering);
  }
}

// Without absorption as much leaves everywhere as enters.
TEST(PolygridDiffusion, KeepsDiffuseLightInEquilibrium) {
  Ball ball(20);
  ball.medium = ObjectMedium({0.2, 0.0});
  ball.lights.resize(1);
  ball.lights[0].diffuse.assign(ball.surface.size(), 1.0);
  const PolygridAnswer answer = ball.solve(12);
  const double entering = diffuse_transmittance(boundary_constants(eta));
  for (const double exitance : answer.exitance) EXPECT_NEAR(exitance, entering, 1e-3 * entering);
}

// The closed form for E = 1 + P₁ on a mesh of its own tessellation.
TEST(PolygridDiffusion, IsTheExactSphereUnderDiffuseLight) {
  Ball ball(40);
  const BoundaryConstants constants = boundary_constants(eta);
  const ExactSphere sphere{radius, coefficients, constants.A};
  const Vector3d axis = Vector3d(2, -1, 2) / 3.0;
  const double transmitted = diffuse_transmittance(constants);
  ball.lights.resize(1);
  std::vector<double> exact;
  for (const Vector3d& position : ball.surface.position) {
    const double cosine = axis.dot(position.normalized());
    ball.lights[0].diffuse.push_back(1.0 + cosine);
    const double q = 4.0 * transmitted / (1.0 - constants.r_phi);
    const double fluence = q * (sphere.lit_from_outside(0) + sphere.lit_from_outside(1) * cosine);
    exact.push_back((fluence - q * (1.0 + cosine)) / (2.0 * constants.A) +
                    transmitted * (1.0 + cosine));
  }
  std::vector<double> errors;
  for (const int n : {8, 16, 32}) {
    errors.push_back(surface_difference(ball.surface, ball.solve(n).exitance, exact) /
                     surface_norm(ball.surface, exact));
  }
  EXPECT_LE(errors[1], 1e-2);
  EXPECT_LE(errors[2], 4e-3);
  EXPECT_LE(errors[2], errors[1]);
}

// The last fluence as start: nothing to do for the same light, less for one nearby.
TEST(PolygridDiffusion, StartsFromTheLastAnswer) {
  Ball ball(20);
  ball.lights = {parallel_beams(ball.surface, Vector3d(0, 0, -1))};
  PolygridDiffusion diffusion(ball_polygrid(12, radius), ball.mesh, ball.surface, eta, "auto");
  const ObjectMedium* const media[] = {&ball.medium};
  diffusion.set_media(media);
  const ObjectProblem problem = ball.problem();
  diffusion.solve({&problem, 1}, {1e-3, 1e-3, 100});
  const int first = diffusion.report().iterations;
  diffusion.solve({&problem, 1}, {1.1e-3, 1e-3, 100});
  EXPECT_EQ(diffusion.report().iterations, 0);
  ball.lights = {parallel_beams(ball.surface, Vector3d(0, 0.05, -1).normalized())};
  diffusion.solve({&problem, 1}, {1e-3, 1e-3, 100});
  EXPECT_LT(diffusion.report().iterations, first);
}

}  // namespace
}  // namespace kappamu::forward::polygrid
