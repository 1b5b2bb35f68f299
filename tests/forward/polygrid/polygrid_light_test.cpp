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
#include "tests/cases/made_polygrid.h"
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

/// Adds one channel's beams to `load`.
void add_beams(const Polygrid& grid, const Ball& ball, const ObjectLight& light,
               std::span<const Coefficients> of_cell, std::vector<double>& load,
               ObjectBalance& balance) {
  const SurfaceMap map(grid, ball.mesh, ball.surface);
  const ChannelBeams channel{light.beams, of_cell, load, balance};
  BeamWalks(grid, map, BeamWalks::Steps::forgotten).add(ball.problem(), {&channel, 1}, 1e-9);
}

/// Loads of several channels, each from zero.
struct Loads {
  explicit Loads(std::size_t corners, std::size_t channels)
      : load(channels, std::vector<double>(corners, 0.0)), balance(channels) {}

  void add(BeamWalks& walks, const ObjectProblem& problem, const std::vector<ObjectLight>& light,
           const std::vector<std::vector<Coefficients>>& of_cell) {
    std::vector<ChannelBeams> channels;
    for (std::size_t c = 0; c < load.size(); ++c) {
      channels.push_back({light[c].beams, of_cell[c], load[c], balance[c]});
    }
    walks.add(problem, channels, 1e-6);
  }
  void expect_near(const Loads& other) const {
    constexpr double rounding = 1e-12;
    for (std::size_t c = 0; c < load.size(); ++c) {
      const double most = *std::max_element(other.load[c].begin(), other.load[c].end());
      EXPECT_GT(most, 0.0);
      for (std::size_t i = 0; i < load[c].size(); ++i) {
        EXPECT_NEAR(load[c][i], other.load[c][i], rounding * most);
      }
      const double power = other.balance[c].entering;
      EXPECT_NEAR(balance[c].entering, power, rounding * power);
      EXPECT_NEAR(balance[c].absorbed, other.balance[c].absorbed, rounding * power);
      EXPECT_NEAR(balance[c].unscattered, other.balance[c].unscattered, rounding * power);
    }
  }

  std::vector<std::vector<double>> load;
  std::vector<ObjectBalance> balance;
};

/// Coefficients that differ from cell to cell.
std::vector<Coefficients> drawn(const Polygrid& grid, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> kappa(0.1, 0.6), mu(0.0, 0.1);
  std::vector<Coefficients> result;
  for (std::size_t k = 0; k < grid.cell.size(); ++k) result.push_back({kappa(random), mu(random)});
  return result;
}

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
  const std::vector<Coefficients> of_cell(grid.cell.size(), coefficients);
  std::vector<double> load(grid.corner.size(), 0.0);
  ObjectBalance balance;
  add_beams(grid, ball, parallel_beams(ball.surface, Vector3d(1, 2, -2) / 3.0), of_cell, load,
            balance);
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
  const std::vector<Coefficients> of_cell(grid.cell.size(), coefficients);
  ObjectLight light;
  const int triangle = 100;
  const Vector3d inward = -ball.surface.normal[triangle];
  light.beams.push_back({triangle, ball.surface.position[triangle], inward, 1.0});
  std::vector<double> load(grid.corner.size(), 0.0);
  ObjectBalance balance;
  add_beams(grid, ball, light, of_cell, load, balance);
  double power = 0.0, depth = 0.0;
  for (std::size_t i = 0; i < load.size(); ++i) {
    power += load[i];
    depth += load[i] * (grid.corner[i] - ball.surface.position[triangle]).dot(inward);
  }
  // Of mesh and polygrid from each other and of chords taken as straight in cells, over the depth.
  constexpr double off_surface = 0.02;
  EXPECT_NEAR(depth / power, 3.0 * coefficients.kappa, off_surface * 3.0 * coefficients.kappa);
}

// One walk serves all channels, also where a channel lacks some of the beams.
TEST(PolygridBeams, OfSeveralChannelsAreThoseOfEach) {
  Ball ball(16);
  const Polygrid grid = ball_polygrid(10, radius);
  const SurfaceMap map(grid, ball.mesh, ball.surface);
  std::vector<ObjectLight> light(3, parallel_beams(ball.surface, Vector3d(1, 2, -2) / 3.0));
  for (Beam& beam : light[1].beams) beam.power *= 0.3;
  for (std::size_t k = 0; 3 * k < light[0].beams.size(); ++k) {
    light[0].beams.erase(light[0].beams.begin() + static_cast<std::ptrdiff_t>(2 * k));
  }
  const std::vector<std::vector<Coefficients>> of_cell{drawn(grid, 1), drawn(grid, 2),
                                                       drawn(grid, 3)};
  Loads together(grid.corner.size(), 3);
  BeamWalks walks(grid, map, BeamWalks::Steps::forgotten);
  together.add(walks, ball.problem(), light, of_cell);
  for (std::size_t c = 0; c < 3; ++c) {
    Loads alone(grid.corner.size(), 1);
    BeamWalks own(grid, map, BeamWalks::Steps::forgotten);
    alone.add(own, ball.problem(), {light[c]}, {of_cell[c]});
    Loads mine(grid.corner.size(), 1);
    mine.load[0] = together.load[c];
    mine.balance[0] = together.balance[c];
    mine.expect_near(alone);
  }
}

// Beams kept through an edit leave what new ones leave, be few or many of them affected and be the
// edited cells clearer, so that beams go on beyond where they ended, or more opaque.
TEST(PolygridBeams, KeptThroughAnEditAreThoseMadeAnew) {
  Ball ball(16);
  const Polygrid grid = ball_polygrid(12, radius);
  const SurfaceMap map(grid, ball.mesh, ball.surface);
  const std::vector<ObjectLight> light(2, parallel_beams(ball.surface, Vector3d(1, 2, -2) / 3.0));
  std::vector<std::vector<Coefficients>> of_cell{drawn(grid, 1), drawn(grid, 2)};
  BeamWalks kept(grid, map, BeamWalks::Steps::kept);
  for (const auto& [from, factor] :
       {std::pair(0.0, 1.0), std::pair(3.5, 8.0), std::pair(3.5, 0.1), std::pair(-9.0, 6.0)}) {
    for (std::size_t k = 0; k < grid.cell.size(); ++k) {
      if (grid.node[k][2] > from) of_cell[1][k].kappa *= factor;
    }
    Loads again(grid.corner.size(), 2), anew(grid.corner.size(), 2);
    again.add(kept, ball.problem(), light, of_cell);
    BeamWalks fresh(grid, map, BeamWalks::Steps::forgotten);
    anew.add(fresh, ball.problem(), light, of_cell);
    again.expect_near(anew);
  }
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

// Light that moves evenly is a combination of the last lights but for a small part: fewer
// iterations than from the last answer alone, to the same answer.
TEST(PolygridDiffusion, MovingLightStartsFromACombinationOfTheLastAnswers) {
  Ball ball(20);
  const ObjectMedium* const media[] = {&ball.medium};
  const PolygridAccuracy accuracy{1e-4, 1e-4, 100};
  const auto make = [&](Lights lights) {
    auto made = std::make_unique<PolygridDiffusion>(ball_polygrid(12, radius), ball.mesh,
                                                    ball.surface, eta, "auto", lights);
    made->set_media(media);
    return made;
  };
  const auto moving = make(Lights::moving), others = make(Lights::others);
  int of_moving = 0, of_others = 0;
  for (int frame = 0; frame < 8; ++frame) {
    ball.lights = {parallel_beams(ball.surface, Vector3d(0, 0.02 * frame, -1).normalized())};
    const ObjectProblem problem = ball.problem();
    const PolygridAnswer one = moving->solve({&problem, 1}, accuracy).front(),
                         other = others->solve({&problem, 1}, accuracy).front();
    EXPECT_LE(surface_difference(ball.surface, one.exitance, other.exitance),
              10.0 * accuracy.linear_tolerance * surface_norm(ball.surface, other.exitance));
    if (frame < 4) continue;
    of_moving += moving->report().iterations;
    of_others += others->report().iterations;
  }
  EXPECT_LT(of_moving, of_others);
}

// A volume edited in part changes the equations there alone, to what they would be made anew.
TEST(PolygridDiffusion, AnEditedMediumIsThatMadeAnew) {
  Ball ball(20);
  ball.lights = {parallel_beams(ball.surface, Vector3d(0, 0, -1))};
  GridShape shape{20, 20, 20, 2.0 * radius / 20.0};
  Medium before{Volume<double>(shape, 0.2), Volume<double>(shape, 0.02)};
  for (std::size_t i = 0; i < shape.cells(); ++i)
    before.kappa[i] *= 1.0 + 0.5 * std::sin(0.7 * static_cast<double>(i));
  Medium edited = before;
  for (int z = 15; z < 20; ++z) {
    for (int x = 8; x < 13; ++x) edited.mu[shape.index(x, 9, z)] *= 20.0;
  }
  const Eigen::Affine3d place(Eigen::Translation3d(Vector3d::Constant(radius)));
  const ObjectMedium one(std::make_shared<Medium>(before), place, Wrap::clamp);
  const ObjectMedium other(std::make_shared<Medium>(edited), place, Wrap::clamp);
  const PolygridAccuracy accuracy{1e-6, 1e-6, 300};
  const auto make = [&](Lights lights) {
    return std::make_unique<PolygridDiffusion>(ball_polygrid(12, radius), ball.mesh, ball.surface,
                                               eta, "auto", lights);
  };
  const auto answer_of = [&](PolygridDiffusion& diffusion, const ObjectMedium& medium) {
    const ObjectMedium* const media[] = {&medium};
    diffusion.set_media(media);
    const ObjectProblem problem = ball.problem();
    return diffusion.solve({&problem, 1}, accuracy).front();
  };
  const auto kept = make(Lights::moving), fresh = make(Lights::others);
  const PolygridAnswer was = answer_of(*kept, one), is = answer_of(*kept, other);
  const PolygridAnswer expected = answer_of(*fresh, other), back = answer_of(*kept, one);
  const double size = surface_norm(ball.surface, expected.exitance);
  EXPECT_GT(surface_difference(ball.surface, was.exitance, is.exitance), 1e-2 * size);
  EXPECT_LE(surface_difference(ball.surface, is.exitance, expected.exitance), 1e-5 * size);
  EXPECT_LE(surface_difference(ball.surface, back.exitance, was.exitance), 1e-5 * size);
  EXPECT_NEAR(is.balance[0].absorbed, expected.balance[0].absorbed,
              1e-5 * expected.balance[0].entering);

  // Of equations solved so loosely that the edit is within the tolerance, it is solved for all the
  // same.
  const auto loose = make(Lights::moving);
  const auto loosely = [&](const ObjectMedium& medium) {
    const ObjectMedium* const media[] = {&medium};
    loose->set_media(media);
    const ObjectProblem problem = ball.problem();
    return loose->solve({&problem, 1}, {0.2, 1e-6, 300}).front();
  };
  const PolygridAnswer before_edit = loosely(one), after_edit = loosely(other);
  EXPECT_GT(loose->report().iterations, 0);
  EXPECT_LT(surface_difference(ball.surface, after_edit.exitance, expected.exitance),
            0.5 * surface_difference(ball.surface, before_edit.exitance, expected.exitance));
}

}  // namespace
}  // namespace kappamu::forward::polygrid
