// Light that begins inside objects against closed forms. The picture of it: RenderedSurface below.
#include "render/light/inner_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "forward/registry.h"
#include "render/light/incident_light.h"
#include "render/render_scene.h"
#include "tests/render/made_scene.h"

namespace kappamu::render {
namespace {

using std::numbers::pi;

constexpr double ball_radius = 10.0, ball_kappa = 0.15, ball_mu = 0.004, ball_eta = 1.3;

Scene lit_sphere() {
  Scene scene = sphere_scene();
  HomogeneousMaterial material;
  material.kappa_mm = Colour::Constant(ball_kappa);
  material.mu_per_mm = Colour::Constant(ball_mu);
  scene.objects[0].material = material;
  return scene;
}

/// Of a unit of power that is scattered at the centre of a ball, by diffusion, what leaves: with
/// u = 4πκ r φ = e^(−αr) + B sinh αr, and φ + 2Aκ φ' = 0 at the surface.
double leaves_of_centre() {
  const double alpha = std::sqrt(ball_mu / ball_kappa),
               robin = 2.0 * boundary_constants(ball_eta).A * ball_kappa;
  const double e = std::exp(-alpha * ball_radius), s = std::sinh(alpha * ball_radius),
               c = std::cosh(alpha * ball_radius), k = 1.0 - robin / ball_radius;
  const double b = -e * (k - robin * alpha) / (s * k + robin * alpha * c);
  const double phi = (e + b * s) / (4.0 * pi * ball_kappa * ball_radius);
  return 4.0 * pi * ball_radius * ball_radius * phi / (2.0 * boundary_constants(ball_eta).A);
}

/// First collisions about the centre, σs' e^(−σt r)/(4πr²), each heard as sinh(αr)/(αr) of the
/// centre's: ∫ σs' e^(−σt r) sinh(αr)/(αr) dr.
double leaves_of_light() {
  const double alpha = std::sqrt(ball_mu / ball_kappa), sigma_t = 1.0 / (3.0 * ball_kappa);
  return leaves_of_centre() * (sigma_t - ball_mu) / (2.0 * alpha) *
         std::log((sigma_t + alpha) / (sigma_t - alpha));
}

struct BallAnswer {
  double entering = 0.0, exiting = 0.0, absorbed = 0.0, unscattered = 0.0, spread = 0.0;
};

BallAnswer ball_answer(const Scene& scene, const std::string& model, double photons = 0.0) {
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const WorldObject& ball = world.objects()[0];
  Progress progress;
  const IncidentLight light =
      incident_light(world, 0, make_light_sources(world.outer_lights()), nullptr, 1, progress);
  const std::vector<forward::ObjectLight> lights{light.channels[0]};
  const auto made = forward::make_object_model(
      model, forward::ModelError::left_out,
      photons > 0.0 ? OptionValues{{"photons", photons}} : OptionValues{});
  forward::ObjectOptions options;
  options.device = "reference";
  const forward::ObjectResult result = made->solve(
      {ball.mesh, ball.surface, *ball.rays, *ball.media.channels[0], ball.boundary.eta, lights},
      options, progress);
  const forward::ObjectBalance& balance = result.balance[0];
  BallAnswer answer{balance.entering, balance.exiting, balance.absorbed, balance.unscattered, 0.0};
  const double mean = balance.exiting / (4.0 * pi * ball_radius * ball_radius);
  double area = 0.0;
  for (std::size_t t = 0; t < result.exitance.size(); ++t) {
    answer.spread += ball.surface.area[t] * std::pow(result.exitance[t] / mean - 1.0, 2);
    area += ball.surface.area[t];
  }
  answer.spread = std::sqrt(answer.spread / area);
  return answer;
}

/// Cubes cut by flat triangles, at a tolerance of 2 %.
constexpr double discretised = 0.02;

TEST(InnerLight, OfABallsCentreLeavesEvenlyAsTheClosedFormHasIt) {
  Scene scene = lit_sphere();
  scene.lights.emplace_back(PointLight{{0.0, 0.0, 0.0}, Colour::Constant(0.25), 2.0});
  const double power = 4.0 * pi * 4.0 * 0.25;
  for (const char* model : {"embedded", "polygrid"}) {
    const BallAnswer answer = ball_answer(scene, model);
    EXPECT_NEAR(answer.entering, power, 1e-6 * power) << model;
    EXPECT_NEAR(answer.exiting, power * leaves_of_light(), discretised * power) << model;
    EXPECT_LT(answer.spread, 2.0 * discretised) << model;
  }
}

/// Near the surface light leaves unevenly: polygrid's cells and cut cubes agree where it does.
TEST(InnerLight, NearTheSurfaceIsTheSameOnPolygridsAndCubes) {
  Scene scene = lit_sphere();
  scene.lights.emplace_back(PointLight{{5.0, 2.0, -3.0}, Colour::Ones(), 1.0});
  const BallAnswer cubes = ball_answer(scene, "embedded"), cells = ball_answer(scene, "polygrid");
  EXPECT_NEAR(cells.exiting, cubes.exiting, discretised * cubes.exiting);
  EXPECT_NEAR(cells.unscattered, cubes.unscattered, 1e-3 * cubes.entering);
  EXPECT_GT(cubes.spread, 0.5);
  EXPECT_NEAR(cells.spread, cubes.spread, 2.0 * discretised * cubes.spread);
}

TEST(InnerLight, OfWalksAgreesWithDiffusion) {
  Scene scene = lit_sphere();
  scene.lights.emplace_back(PointLight{{0.0, 0.0, 0.0}, Colour::Ones(), 1.0});
  const BallAnswer walks = ball_answer(scene, "montecarlo", 20'000.0);
  const double power = 4.0 * pi;
  EXPECT_NEAR(walks.exiting + walks.absorbed + walks.unscattered, power, 1e-3 * power);
  // 20,000 photons: one standard error of a share of about a half is 0.4 %.
  EXPECT_NEAR(walks.exiting / power, leaves_of_light(), 0.02);
}

TEST(InnerLight, OfAGlowingBallIsItsVolumesAndBalances) {
  Scene scene = lit_sphere();
  scene.objects[0].emission = Colour(0.1, 0.0, 0.2);
  scene.lights.emplace_back(EnvironmentLight{});
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const auto beams = inner_beams(world, 0, 1);
  EXPECT_TRUE(beams[1].empty());
  double power = 0.0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const forward::Beam& beam : beams[0]) {
    power += beam.power;
    middle += beam.position;
    EXPECT_LT(beam.position.norm(), ball_radius);
  }
  const double volume = enclosed_volume(world.objects()[0].mesh);
  EXPECT_NEAR(power, 0.1 * volume, 1e-9 * volume);
  EXPECT_LT((middle / static_cast<double>(beams[0].size())).norm(), 0.01 * ball_radius);

  const BallAnswer walks = ball_answer(scene, "montecarlo", 20'000.0);
  for (const char* model : {"embedded", "polygrid"}) {
    const BallAnswer diffusion = ball_answer(scene, model);
    EXPECT_NEAR(diffusion.exiting + diffusion.absorbed + diffusion.unscattered, diffusion.entering,
                discretised * diffusion.entering);
    EXPECT_NEAR(diffusion.exiting / diffusion.entering, walks.exiting / walks.entering, 0.03);
    EXPECT_NEAR(diffusion.unscattered / diffusion.entering, walks.unscattered / walks.entering,
                0.01);
  }
}

/// A ball whose medium neither scatters nor absorbs much shows its emission along the ray: the
/// radiance ε/(4π) times the way inside, through the middle.
TEST(InnerLight, OfAClearGlowingBallIsSeenAlongTheRay) {
  Scene scene = lit_sphere();
  HomogeneousMaterial clear;
  clear.kappa_mm = Colour::Constant(1e3);
  clear.mu_per_mm = Colour::Constant(1e-6);
  scene.objects[0].material = clear;
  scene.objects[0].finish.eta = 1.0;
  scene.objects[0].emission = Colour::Constant(0.4);
  EnvironmentLight dark;
  dark.radiance = Colour::Zero();
  scene.lights.emplace_back(dark);
  scene.camera.fov_deg = 0.5;
  KnownAnswer nothing([](const forward::ObjectProblem&, std::size_t, std::size_t) { return 0.0; });
  Progress progress;
  const RenderResult result = render_scene(scene, nothing, {.device = "reference"}, progress);
  const double expected = 0.4 / (4.0 * pi) * 2.0 * ball_radius;
  EXPECT_NEAR(result.picture.radiance(12, 12, 1), expected, 0.01 * expected);
}

TEST(InnerLight, IsRefusedByModelsWithoutTheAbility) {
  Scene scene = lit_sphere();
  scene.objects[0].edges_per_size = 8;
  scene.lights.emplace_back(PointLight{{1.0, 0.0, 0.0}, Colour::Ones(), 1.0});
  int refused = 0;
  for (const forward::ModelDescription& model : forward::object_models()) {
    if (model.can.inner_light) continue;
    EXPECT_THROW(ball_answer(scene, model.name), InputError) << model.name;
    ++refused;
  }
  EXPECT_GT(refused, 2);
}

}  // namespace
}  // namespace kappamu::render
