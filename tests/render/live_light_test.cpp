// Light of the window that does not come along one ray from outside: an environment's lamps and
// light that begins inside objects, as `kappamu render` has it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "forward/registry.h"
#include "io/image/image_file.h"
#include "render/light/incident_light.h"
#include "render/live/light_handle.h"
#include "render/live/live_scene.h"
#include "tests/own_folder.h"
#include "tests/render/made_scene.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;

constexpr double live_tolerance = 0.1;

double power_of(const LiveScene& live, const LiveAnswer& answer, std::size_t channel = 1) {
  const Surface& surface = live.world().objects()[0].surface;
  double power = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    power += surface.area[t] * answer.exitance[0].exitance[channel][t];
  }
  return power;
}

/// Relative, in the surface's 2-norm, of G.
double apart(const std::vector<double>& one, const std::vector<double>& other,
             const Surface& surface) {
  double difference = 0.0, size = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    difference += surface.area[t] * std::pow(one[t] - other[t], 2);
    size += surface.area[t] * other[t] * other[t];
  }
  return std::sqrt(difference / size);
}

LiveAnswer settled(LiveScene& live, const LiveQuestion& question) {
  Progress progress;
  LiveAnswer last = live.answer(question, progress);
  while (const auto better = live.refined(progress)) last = *better;
  return last;
}

/// Exitance of G as `kappamu render` has it by the model embedded, as exactly as `answer` is.
std::vector<double> rendered(const Scene& scene, LampsEnter lamps, const LiveAnswer& answer) {
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const WorldObject& object = world.objects()[0];
  const auto environment = make_environment(scene.lights, lamps);
  Progress progress;
  const IncidentLight light = incident_light(world, 0, make_light_sources(world.outer_lights()),
                                             environment ? &*environment : nullptr, 1, progress);
  const forward::LiveBody body{object.mesh,           object.surface,      *object.rays,
                               object.media.channels, object.boundary.eta, nullptr};
  const forward::ChannelProblems problems(body, light.channels);
  forward::ObjectOptions options;
  options.tolerance = answer.level == 0 ? 0.3 : live_tolerance;  // ObjectSolver::solve_anew()
  return forward::make_object_model("embedded")
      ->solve_channels(problems.all(), options, progress)[1]
      .exitance;
}

/// A ball under a dim sky with a lamp of 50° by 50° behind it, and a lamp in front.
class LiveLamps : public testing::Test {
 protected:
  LiveLamps() {
    constexpr int rows = 36, columns = 72;
    Image<float> sky(columns, rows, 3, 0.05F);
    for (int y = 13; y < 23; ++y) {
      for (int x = 31; x < 41; ++x) {
        for (int c = 0; c < 3; ++c) sky(x, y, c) = 3.0F;
      }
    }
    io::write_float_image(folder_ / "sky.exr", sky);
    scene_ = sphere_scene();
    scene_.objects[0].edges_per_size = 24;
    scene_.lights = {DirectionalLight{-Vector3d::UnitZ(), Colour::Constant(0.02)},
                     EnvironmentLight{folder_ / "sky.exr", Colour::Ones(), 0.0, true}};
  }

  const OwnFolder folder_;
  Scene scene_;
};

LiveOptions options_of(const std::string& model) {
  LiveOptions options;
  options.model = model;
  options.tolerance = live_tolerance;
  return options;
}

/// At rest, by the model embedded.
double apart_from_render(const Scene& scene, LampsEnter lamps) {
  std::vector<std::string> warnings;
  LiveScene live(scene, options_of("embedded"), warnings);
  const LiveAnswer answer = settled(live, {scene.lights, {}});
  return apart(answer.exitance[0].exitance[1], rendered(scene, lamps, answer),
               live.world().objects()[0].surface);
}

TEST_F(LiveLamps, EnterAsBeamsAsRenderHasThem) {
  std::vector<std::string> warnings;
  LiveScene live(scene_, options_of("embedded"), warnings);
  const LiveAnswer answer = settled(live, {scene_.lights, {}});
  const Surface& surface = live.world().objects()[0].surface;
  const auto& seen = answer.exitance[0].exitance[1];
  const double as_beams = apart(seen, rendered(scene_, LampsEnter::as_beams, answer), surface);
  const double evenly = apart(seen, rendered(scene_, LampsEnter::evenly, answer), surface);
  EXPECT_LT(as_beams, 1e-3);
  EXPECT_GT(evenly, 0.02);
}

/// What is kept of the lamps while another light turns is what a fresh scene finds, and a sky that
/// turns is followed.
TEST_F(LiveLamps, StayWhileAnotherLightTurnsAndFollowTheirSky) {
  std::vector<std::string> warnings;
  LiveScene live(scene_, options_of("polygrid"), warnings);
  settled(live, {scene_.lights, {}});
  std::vector<Light> lights = scene_.lights;
  lights[0] = turned_to(lights[0], Vector3d::Zero(), {70.0, 20.0});
  const auto fresh = [&] {
    LiveScene other(scene_, options_of("polygrid"), warnings);
    return settled(other, {lights, {}}).exitance[0].exitance[1];
  };
  const Surface& surface = live.world().objects()[0].surface;
  const LiveAnswer turned = settled(live, {lights, {}});
  EXPECT_LT(apart(turned.exitance[0].exitance[1], fresh(), surface), 0.02);
  std::get<EnvironmentLight>(lights[1]).turn_deg = 90.0;
  const LiveAnswer other_sky = settled(live, {lights, {}});
  EXPECT_GT(apart(other_sky.exitance[0].exitance[1], turned.exitance[0].exitance[1], surface), 0.3);
  EXPECT_LT(apart(other_sky.exitance[0].exitance[1], fresh(), surface), 0.02);
}

/// Of an even sky nothing enters as beams.
TEST_F(LiveLamps, AnEvenSkyHasNone) {
  scene_.lights = {EnvironmentLight{std::nullopt, Colour::Ones(), 0.0, true}};
  EXPECT_LT(apart_from_render(scene_, LampsEnter::evenly), 1e-3);
}

/// What arrives on surfaces is kept while lights stay, and no longer: a spot turns away in place.
TEST(LiveSurface, FollowsEveryFieldOfALight) {
  Scene scene = sphere_scene();
  scene.objects[0].edges_per_size = 24;
  scene.lights = {SpotLight{{{0.0, 0.0, 40.0}, Colour::Ones(), 40.0}, Vector3d::Zero(), 60.0, 5.0}};
  std::vector<std::string> warnings;
  LiveScene live(scene, {}, warnings);
  Progress progress;
  const auto arriving = [&] {
    const LiveAnswer answer = live.answer({scene.lights, {}}, progress);
    float sum = 0.0F;
    for (const Eigen::Array3f& here : answer.surface[0].arriving[0]) sum += here.sum();
    return sum;
  };
  const float lit = arriving();
  EXPECT_GT(lit, 0.0F);
  EXPECT_EQ(arriving(), lit);
  std::get<SpotLight>(scene.lights[0]).target_mm = {0.0, 0.0, 80.0};
  EXPECT_EQ(arriving(), 0.0F);
}

/// A ball of one medium with a point light somewhere.
Scene ball_with_light(const Vector3d& place) {
  Scene scene = sphere_scene();
  scene.objects[0].edges_per_size = 24;
  scene.lights = {PointLight{place, Colour(1.0, 0.8, 0.5), 1.0}};
  return scene;
}

TEST(LiveInnerLight, IsAsRenderHasIt) {
  EXPECT_LT(apart_from_render(ball_with_light({4.0, 3.0, 0.0}), LampsEnter::as_beams), 1e-3);
}

/// Models that take light from outside alone are no choice while a light is inside.
TEST(LiveInnerLight, IsFollowedInAndOutByModelsThatCan) {
  Scene scene = ball_with_light({0.0, 0.0, 30.0});
  std::vector<std::string> warnings;
  LiveScene live(scene, {}, warnings);
  const LiveAnswer outside = settled(live, {scene.lights, {}});
  std::get<PointLight>(scene.lights[0]).position_mm = {0.0, 5.0, 0.0};
  Progress progress;
  const LiveAnswer inside = live.answer({scene.lights, {}}, progress);
  EXPECT_TRUE(forward::object_model(inside.model).can.inner_light) << inside.model;
  for (const std::string& model : live_models(live.world())) {
    EXPECT_TRUE(forward::object_model(model).can.inner_light) << model;
  }
  EXPECT_GT(power_of(live, inside), 0.5 * 4.0 * std::numbers::pi * 0.8);
  // Upwards it is nearer to the surface.
  const Surface& surface = live.world().objects()[0].surface;
  double above = 0.0, below = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    (surface.position[t].y() > 0.0 ? above : below) +=
        surface.area[t] * inside.exitance[0].exitance[1][t];
  }
  EXPECT_GT(above, 2.0 * below);
  // Light is linear in what it sends.
  intensity_of(scene.lights[0]) *= 2.0;
  const LiveAnswer brighter = live.answer({scene.lights, {}}, progress);
  EXPECT_NEAR(power_of(live, brighter), 2.0 * power_of(live, inside),
              0.02 * power_of(live, brighter));
  // A person who asks for a dipole is told why not.
  const LiveAnswer refused = live.answer({scene.lights, {}, "dipole-rotated"}, progress);
  EXPECT_THAT(refused.refused,
              testing::HasSubstr("model dipole-rotated takes light from outside alone"));
  EXPECT_TRUE(forward::object_model(refused.model).can.inner_light);
  std::get<PointLight>(scene.lights[0]).position_mm = {0.0, 0.0, 30.0};
  intensity_of(scene.lights[0]) /= 2.0;
  const LiveAnswer again = settled(live, {scene.lights, {}, "dipole-rotated"});
  EXPECT_EQ(again.refused, "");
  EXPECT_EQ(again.model, "dipole-rotated");
  EXPECT_NEAR(power_of(live, again), power_of(live, outside), 0.2 * power_of(live, outside));
}

TEST(LiveInnerLight, ABodyThatGlowsIsShown) {
  Scene scene = sphere_scene();
  scene.objects[0].edges_per_size = 24;
  scene.objects[0].emission = Colour(0.1, 0.05, 0.0);
  scene.lights = {DirectionalLight{-Vector3d::UnitZ(), Colour::Zero()}};
  std::vector<std::string> warnings;
  LiveScene live(scene, options_of("embedded"), warnings);
  const LiveAnswer answer = settled(live, {scene.lights, {}});
  EXPECT_LT(apart(answer.exitance[0].exitance[1], rendered(scene, LampsEnter::as_beams, answer),
                  live.world().objects()[0].surface),
            1e-3);
  // What is drawn without a collision: ε/(4πσt'), along every ray of a deep body.
  ASSERT_EQ(answer.surface[0].below->glow.size(), live.world().objects()[0].surface.size());
  EXPECT_NEAR(answer.surface[0].below->glow[5][1], 0.05 * 3.0 * 0.15 / (4.0 * std::numbers::pi),
              1e-12);
}

/// While a body is twisted about a light inside it, answers are of the shape as it is.
TEST(LiveInnerLight, FollowsAShapeThatMoves) {
  Scene scene = ball_with_light({0.0, 2.0, 3.0});
  scene.objects[0].shape = std::string("slab");
  scene.objects[0].proportion = 0.5;
  Deformation twist;
  twist.kind = DeformKind::twist;
  twist.axis = Vector3d::UnitZ();
  std::vector<std::string> warnings;
  LiveScene live(scene, options_of("polygrid"), warnings);
  Progress progress;
  live.answer({scene.lights, {}}, progress);
  std::vector<Deformation> deform{twist};
  LiveAnswer moving;
  for (const double degrees : {10.0, 25.0, 40.0}) {
    deform[0].amount = degrees;
    moving = live.answer({scene.lights, {}, "", {{{0, deform}}, true}}, progress);
    EXPECT_EQ(moving.moved.size(), 1U);
  }
  const auto expect_as_fresh = [&](const LiveAnswer& answer) {
    Scene other = scene;
    other.objects[0].deform = deform;
    LiveScene fresh(other, options_of("polygrid"), warnings);
    EXPECT_LT(apart(answer.exitance[0].exitance[1],
                    fresh.answer({scene.lights, {}}, progress).exitance[0].exitance[1],
                    fresh.world().objects()[0].surface),
              0.05);
  };
  expect_as_fresh(moving);
  // A shape may leave a light behind: it then lights from outside.
  deform[0].kind = DeformKind::scale;
  deform[0].amount = 0.4;
  expect_as_fresh(live.answer({scene.lights, {}, "", {{{0, deform}}, true}}, progress));
}

}  // namespace
}  // namespace kappamu::render
