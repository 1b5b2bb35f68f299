// Places of beams on a surface. Light that arrives there is tested in incident_light_test.cpp.
#include "render/light/beam_places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mesh/mesh_refine.h"
#include "tests/render/made_scene.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

// Fewer places than triangles, and larger ones with several: the same light from afar.
TEST(BeamPlaces, StandForAllOfTheSurface) {
  Scene scene = sphere_scene();
  scene.lights.emplace_back(
      DirectionalLight{Vector3d(1.0, -2.0, 0.5).normalized(), Colour::Ones()});
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const WorldObject& object = world.objects()[0];
  double area = 0.0;
  for (const double of_triangle : object.surface.area) area += of_triangle;
  for (const double spacing : {0.05, 0.3, 1.0, 2.0}) {
    const std::vector<BeamPlace> places = beam_places(object, {spacing, spacing});
    Vector3d whole = Vector3d::Zero();
    for (std::size_t k = 0; k < places.size(); ++k) {
      whole += places[k].area;
      const auto t = static_cast<std::size_t>(places[k].triangle);
      EXPECT_NEAR((places[k].position - object.surface.position[t]).dot(object.surface.normal[t]),
                  0.0, 1e-9);
      EXPECT_GE(places[k].triangle, places[k == 0 ? 0 : k - 1].triangle);
    }
    EXPECT_LT(whole.norm(), 1e-9 * area);
    EXPECT_NEAR(static_cast<double>(places.size()), area / (spacing * spacing),
                0.4 * area / (spacing * spacing));
    const auto light = beams_at(world, 0, make_light_sources(scene.lights), places);
    double power = 0.0;
    for (const forward::Beam& beam : light[0].beams) power += beam.power;
    EXPECT_NEAR(power, pi * 100.0, 0.01 * pi * 100.0);
  }
}

/// Middles of congruent parts: a mesh whose triangles are split in four has the very same places.
TEST(BeamPlaces, DoNotDependOnTheTessellationOfASurface) {
  Scene scene = sphere_scene();
  scene.objects[0].shape = std::string("cube");
  scene.objects[0].edges_per_size = 4;
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const WorldObject& coarse = world.objects()[0];
  WorldObject fine;
  fine.mesh = refined(coarse.mesh, 0.8 * 20.0 / 4, 1'000'000);
  fine.surface = surface_of(fine.mesh);
  ASSERT_EQ(fine.surface.size(), 4 * coarse.surface.size());
  const double apart = 0.5 * std::sqrt(coarse.surface.area[0]);
  const std::vector<BeamPlace> parts = beam_places(coarse, {apart, 0.0}),
                               whole = beam_places(fine, {apart, 0.0});
  ASSERT_EQ(parts.size(), whole.size());
  for (const BeamPlace& place : whole) {
    EXPECT_TRUE(std::any_of(parts.begin(), parts.end(), [&](const BeamPlace& other) {
      return (other.position - place.position).norm() < 1e-12 * 20.0 &&
             (other.area - place.area).norm() < 1e-9 * place.area.norm();
    }));
  }
}

/// Of a smooth light on flat triangles.
TEST(BeamPlaces, AreOfSecondOrder) {
  Scene scene = sphere_scene();
  scene.objects[0].shape = std::string("cube");
  scene.objects[0].edges_per_size = 4;
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const double edge = 5.0 / std::sqrt(2.0);
  const auto power = [&](int rows) {
    double sum = 0.0;
    for (const BeamPlace& place : beam_places(world.objects()[0], {edge / rows, 0.0})) {
      const Vector3d& x = place.position;
      sum += place.area.norm() * std::exp(0.1 * x.x()) * std::cos(0.1 * x.y() + 0.2 * x.z());
    }
    return sum;
  };
  // ∫ e^(x/10) = 20 sinh 1, ∫ cos(y/10) = 20 sin 1 and ∫ cos(z/5) = 10 sin 2 over [-10, 10]³.
  const double in_x = 20.0 * std::sinh(1.0), in_y = 20.0 * std::sin(1.0),
               in_z = 10.0 * std::sin(2.0);
  const double expected = 2.0 * std::cosh(1.0) * in_y * in_z + 2.0 * std::cos(1.0) * in_x * in_z +
                          2.0 * std::cos(2.0) * in_x * in_y;
  double before = std::abs(power(1) - expected);
  EXPECT_LT(before, 0.1 * expected);
  for (const int rows : {2, 4, 8}) {
    const double error = std::abs(power(rows) - expected);
    EXPECT_GT(before / error, 3.7) << rows;
    before = error;
  }
}

}  // namespace
}  // namespace kappamu::render
