// Lights that move: handles keep what they must, and a live answer is the model's own.
#include "render/live/live_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "forward/registry.h"
#include "io/polycube_file.h"
#include "render/light/incident_light.h"
#include "render/live/light_handle.h"
#include "render/material/published_materials.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

constexpr double rounding = 1e-9;
/// Of two hierarchies, one with wider links than the other: each sums within 2 %.
constexpr double sum_tolerance = 0.02;

Scene lit_ball() {
  SceneObject ball;
  ball.name = "ball";
  ball.shape = std::string("sphere");
  ball.size_mm = 20.0;
  ball.material = published_material("marble");
  Scene scene;
  scene.file = "scene.json";
  scene.objects = {ball};
  scene.lights = {DirectionalLight{-Eigen::Vector3d::UnitZ(), {1.0, 0.9, 0.8}},
                  EnvironmentLight{std::nullopt, Colour::Constant(0.1), 0.0, true}};
  scene.camera.position_mm = {0.0, 0.0, 80.0};
  return scene;
}

/// A better answer that comes before anyone has seen the one to a shape states how it was followed.
TEST(LiveAnswer, StatesWhatNobodyHasSeen) {
  LiveAnswer followed, better;
  followed.mode = "incremental";
  followed.shape_ms = 3.0;
  followed.moved[0] = {Eigen::Vector3d::Zero()};
  better.model_ms = 5.0;
  better.take_over(followed);
  EXPECT_EQ(better.mode, "incremental");
  EXPECT_EQ(better.total_ms(), 3.0);
  EXPECT_EQ(better.moved.size(), 1U);
}

TEST(LightHandle, TurnsAtItsDistanceAndBack) {
  const Eigen::Vector3d centre(1.0, 2.0, 3.0);
  PointLight point;
  point.position_mm = {10.0, 5.0, -7.0};
  SpotLight spot;
  spot.point = point;
  for (const Light& light : {Light(point), Light(spot), Light(DirectionalLight())}) {
    const Light turned = turned_to(light, centre, {40.0, -25.0});
    EXPECT_NEAR(angles_of(turned, centre).azimuth_deg, 40.0, rounding);
    EXPECT_NEAR(angles_of(turned, centre).elevation_deg, -25.0, rounding);
    if (const auto* at = std::get_if<PointLight>(&turned)) {
      EXPECT_NEAR((at->position_mm - centre).norm(), (point.position_mm - centre).norm(), rounding);
    }
  }
  const Light home =
      turned_to(turned_to(point, centre, {40.0, -25.0}), centre, angles_of(point, centre));
  EXPECT_LT((std::get<PointLight>(home).position_mm - point.position_mm).norm(), rounding);
  for (const Light& light : {Light(point), Light(DirectionalLight()), Light(EnvironmentLight())}) {
    const Eigen::Vector3d there = Eigen::Vector3d(0.6, 0.0, -0.8);
    EXPECT_LT((towards(turned_towards(light, centre, there), centre) - there).norm(), rounding);
  }
  EXPECT_NEAR(distance_of(at_distance(point, centre, 7.0), centre).value(), 7.0, rounding);
  EXPECT_FALSE(distance_of(DirectionalLight(), centre));
  EXPECT_FALSE(has_angles(EnvironmentLight()));
  EXPECT_THROW(turned_to(EnvironmentLight(), centre, {}), InputError);
}

TEST(LiveScene, AnswersAsTheModelForMovedLights) {
  const Scene scene = lit_ball();
  std::vector<std::string> warnings;
  LiveScene live(scene, {}, warnings);
  Progress progress;
  std::vector<Light> lights = scene.lights;
  EXPECT_EQ(live.answer({lights, {}}, progress).model, "dipole-rotated");
  lights[0] = turned_to(lights[0], Eigen::Vector3d::Zero(), {120.0, 30.0});
  const LiveAnswer moved = live.answer({lights, {}}, progress);
  EXPECT_EQ(moved.model, "dipole-rotated");

  const WorldObject& ball = live.world().objects()[0];
  const std::optional<Environment> environment = make_environment(lights);
  const IncidentLight light =
      incident_light(live.world(), 0, make_light_sources(lights), &*environment, 1, progress);
  const auto model = forward::make_object_model("dipole-rotated");
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<forward::ObjectLight> one{light.channels[c]};
    const forward::ObjectResult fresh = model->solve(
        {ball.mesh, ball.surface, *ball.rays, *ball.media.channels[c], ball.boundary.eta, one}, {},
        progress);
    double difference = 0.0, size = 0.0;
    for (std::size_t t = 0; t < ball.surface.size(); ++t) {
      const double apart = moved.exitance[0].exitance[c][t] - fresh.exitance[t];
      difference += ball.surface.area[t] * apart * apart;
      size += ball.surface.area[t] * fresh.exitance[t] * fresh.exitance[t];
    }
    EXPECT_LT(difference, sum_tolerance * sum_tolerance * size) << c;
  }
}

// The equations of the polygrid stay: a light that comes back finds its answer, and one nearby
// takes fewer iterations than the first.
TEST(LiveScene, TakesADrawnPolycube) {
  const OwnFolder folder;
  io::write_polycube(lattice_polycube({{0, 0, 0}}, Eigen::Vector3d::Constant(-6.0), 12.0),
                     folder / "drawn.json");
  Scene scene = lit_ball();
  scene.objects[0].polycube = folder / "drawn.json";
  std::vector<std::string> warnings;
  Progress progress;
  const auto answered = [&] {
    return LiveScene(scene, {"polygrid", {}, "auto", 1}, warnings)
        .answer({scene.lights, {}}, progress);
  };
  EXPECT_NO_THROW(answered());
  scene.objects[0].shape = std::string("torus");
  EXPECT_THAT(sentence_of([&] { answered(); }),
              testing::HasSubstr("drawn.json: the polycube has genus 0, the mesh 1"));
}

TEST(LiveScene, KeepsThePolygridFromLightToLight) {
  const Scene scene = lit_ball();
  std::vector<std::string> warnings;
  LiveOptions options;
  options.model = "polygrid";
  LiveScene live(scene, options, warnings);
  Progress progress;
  std::vector<Light> lights = scene.lights;
  const LiveAnswer first = live.answer({lights, {}}, progress);
  EXPECT_TRUE(first.converged);
  EXPECT_GT(first.iterations, 2);
  EXPECT_EQ(live.answer({lights, {}}, progress).iterations, 0);
  lights[0] = turned_to(lights[0], Eigen::Vector3d::Zero(), {2.0, 0.0});
  live.answer({lights, {}}, progress);
  lights[0] = turned_to(lights[0], Eigen::Vector3d::Zero(), {4.0, 0.0});
  const LiveAnswer moved = live.answer({lights, {}}, progress);
  EXPECT_LT(moved.iterations, first.iterations);
  EXPECT_NE(moved.exitance[0].exitance[1], first.exitance[0].exitance[1]);
}

// A coarse answer comes first; refining ends within the tolerance, and then there is nothing to do.
TEST(LiveScene, SharpensUpToTheTolerance) {
  const Scene scene = lit_ball();
  std::vector<std::string> warnings;
  LiveOptions options;
  options.model = "polygrid";
  options.tolerance = 0.05;
  LiveScene live(scene, options, warnings);
  Progress progress;
  const LiveAnswer first = live.answer({scene.lights, {}}, progress);
  EXPECT_FALSE(first.error_estimate);
  LiveAnswer last = first;
  constexpr int most_steps = 10;
  int steps = 0;
  while (const auto better = live.refined(progress)) {
    EXPECT_GE(better->elements, last.elements);
    last = *better;
    ASSERT_LT(++steps, most_steps);
  }
  ASSERT_TRUE(last.error_estimate);
  EXPECT_LE(*last.error_estimate, options.tolerance);
  EXPECT_GT(last.elements, first.elements);
  EXPECT_FALSE(live.refined(progress));
}

// A listener that gives up leaves a scene that answers the next question as if nothing had been.
TEST(LiveScene, AnswersAfterItWasInterrupted) {
  class Impatient : public Progress {
    void update(const std::string&, double, const std::string&) override { throw Cancelled(); }
  };
  const Scene scene = lit_ball();
  std::vector<std::string> warnings;
  LiveOptions options;
  options.model = "polygrid";
  LiveScene live(scene, options, warnings), undisturbed(scene, options, warnings);
  Impatient impatient;
  Progress progress;
  EXPECT_THROW(live.answer({scene.lights, {}}, impatient), Cancelled);
  const LiveAnswer answer = live.answer({scene.lights, {}}, progress);
  EXPECT_TRUE(live.refined(progress));
  EXPECT_THROW(live.refined(impatient), Cancelled);
  const LiveAnswer expected = undisturbed.answer({scene.lights, {}}, progress);
  EXPECT_EQ(answer.elements, expected.elements);
  EXPECT_EQ(answer.exitance[0].diffuse[1], expected.exitance[0].diffuse[1]);
}

// Light is linear: twice the environment's radiance doubles what arrives of it.
TEST(LiveScene, FollowsTheEnvironment) {
  Scene scene = lit_ball();
  std::vector<std::string> warnings;
  LiveScene live(scene, {}, warnings);
  Progress progress;
  const LiveAnswer before = live.answer({scene.lights, {}}, progress);
  intensity_of(scene.lights[1]) *= 2.0;
  const LiveAnswer after = live.answer({scene.lights, {}}, progress);
  const auto& was = before.exitance[0].diffuse[1];
  const auto& is = after.exitance[0].diffuse[1];
  for (std::size_t t = 0; t < was.size(); ++t) {
    EXPECT_NEAR(is[t], 2.0 * was[t], 1e-6 * is[t]) << t;  // images are of single precision
  }
}

/// A scene of a shape, in marble, under a spot and an even sky.
Scene lit_shape(const char* shape, double proportion) {
  Scene scene = lit_ball();
  scene.objects[0].shape = std::string(shape);
  scene.objects[0].proportion = proportion;
  SpotLight spot;
  spot.point = {{20.0, 40.0, 60.0}, {1.0, 0.9, 0.8}, 70.0};
  spot.cone_deg = 40.0;
  scene.lights[0] = spot;
  return scene;
}

Deformation along_z(DeformKind kind, double degrees) {
  Deformation deformation;
  deformation.kind = kind;
  deformation.amount = degrees;
  deformation.axis = Eigen::Vector3d::UnitZ();
  return deformation;
}

double apart(const LiveAnswer& one, const LiveAnswer& other, const Surface& surface) {
  double difference = 0.0, size = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t t = 0; t < surface.size(); ++t) {
      const double exact = other.exitance[0].exitance[c][t];
      difference += surface.area[t] * std::pow(one.exitance[0].exitance[c][t] - exact, 2);
      size += surface.area[t] * exact * exact;
    }
  }
  return std::sqrt(difference / size);
}

/// The last answer, once there is no better one: with all of the sky's light.
LiveAnswer settled(LiveScene& live) {
  Progress progress;
  LiveAnswer last;
  while (const auto better = live.refined(progress)) last = *better;
  return last;
}

// After any way through shapes, the answer at rest is that of a scene which had the shape at once.
TEST(LiveShape, AnswerAtRestIsTheAnswerFromScratch) {
  constexpr double promised = 0.01;
  for (const auto& [shape, proportion] : {std::pair{"slab", 0.3}, std::pair{"candle", 0.5}}) {
    Scene scene = lit_shape(shape, proportion);
    std::vector<std::string> warnings;
    LiveOptions options;
    options.model = "dipole-rotated";
    LiveScene live(scene, options, warnings);
    Progress progress;
    live.answer({scene.lights, {}}, progress);
    std::vector<Deformation> deform{along_z(DeformKind::twist, 0.0), Deformation()};
    deform[1].kind = DeformKind::noise;
    deform[1].amount = 0.1;
    deform[1].wavelength_mm = 4.0;
    LiveAnswer last;
    for (const double degrees : {10.0, 25.0, 55.0, 40.0}) {
      deform[0].amount = degrees;
      last = live.answer({scene.lights, {}, "", {{{0, deform}}, true}}, progress);
      EXPECT_EQ(last.mode, "incremental");
      EXPECT_EQ(last.moved.size(), 1U);
    }
    last = live.answer({scene.lights, {}, "", {{{0, deform}}, false}}, progress);
    EXPECT_TRUE(last.caught_up);
    EXPECT_EQ(last.shape_refused, "");
    scene.objects[0].deform = deform;
    LiveScene fresh(scene, options, warnings);
    fresh.answer({scene.lights, {}}, progress);
    EXPECT_LT(apart(settled(live), settled(fresh), fresh.world().objects()[0].surface), promised)
        << shape;
    // And what is drawn is what was solved.
    live.show(last);
    EXPECT_EQ(live.world().objects()[0].mesh.vertices, fresh.world().objects()[0].mesh.vertices);
    const LiveAnswer still = live.answer({scene.lights, {}, "", {{{0, deform}}, false}}, progress);
    EXPECT_EQ(still.mode, "static");
    EXPECT_TRUE(still.moved.empty());
  }
}

TEST(LiveShape, AShapeThatCrossesItselfIsTakenBack) {
  const Scene scene = lit_shape("cylinder", 0.1);
  std::vector<std::string> warnings;
  LiveScene live(scene, {}, warnings);
  Progress progress;
  std::vector<Deformation> bend{along_z(DeformKind::bend, 90.0)};
  const LiveAnswer good = live.answer({scene.lights, {}, "", {{{0, bend}}, false}}, progress);
  EXPECT_TRUE(good.shape_refused.empty()) << good.shape_refused;
  bend[0].amount = 360.0;
  EXPECT_TRUE(
      live.answer({scene.lights, {}, "", {{{0, bend}}, true}}, progress).shape_refused.empty());
  const LiveAnswer bad = live.answer({scene.lights, {}, "", {{{0, bend}}, false}}, progress);
  EXPECT_THAT(bad.shape_refused,
              testing::HasSubstr("object 'ball': deform[0], bend of 360 degrees"));
  EXPECT_EQ(bad.moved.at(0), good.moved.at(0));
}

// A model that keeps nothing follows too: it is asked for the shape as it is.
TEST(LiveShape, EveryLiveModelFollows) {
  Scene scene = lit_shape("slab", 0.4);
  scene.objects[0].size_mm = 12.0;
  std::vector<std::string> warnings;
  const std::vector<Deformation> twist{along_z(DeformKind::twist, 30.0)};
  LiveScene live(scene, {}, warnings);
  Progress progress;
  for (const char* model : {"polygrid", "embedded"}) {
    const LiveAnswer answer =
        live.answer({scene.lights, {}, model, {{{0, twist}}, false}}, progress);
    Scene twisted = scene;
    twisted.objects[0].deform = twist;
    LiveOptions options;
    options.model = model;
    LiveScene fresh(twisted, options, warnings);
    const LiveAnswer other = fresh.answer({scene.lights, {}}, progress);
    EXPECT_EQ(answer.model, model);
    EXPECT_EQ(answer.mode == "incremental", model == std::string("polygrid"));
    EXPECT_LT(apart(answer, other, fresh.world().objects()[0].surface), 0.05) << model;
  }
}

}  // namespace
}  // namespace kappamu::render
