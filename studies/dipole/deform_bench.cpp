// Section `deform`: [M] Tables 3 and 4 for objects that deform, by the path that the window takes
// (render/live): vertices moved, shadows, light, links, sum. Each frame has a shape of its own.
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/processor_time.h"
#include "render/live/live_scene.h"
#include "render/material/published_materials.h"
#include "studies/dipole/dipole_bench.h"

namespace kappamu::studies {

namespace {

using render::Deformation;
using render::DeformKind;
using render::FollowBy;

struct Object {
  const char* name;
  const char* shape;
  double proportion;
  int facets;  ///< along the longest edge
  double size_mm;
  std::vector<Deformation> deform;  ///< of a frame at its largest
};

Deformation along_z(DeformKind kind, double amount) {
  Deformation deformation;
  deformation.kind = kind;
  deformation.amount = amount;
  deformation.axis = Eigen::Vector3d::UnitZ();
  return deformation;
}

Deformation brushed(DeformKind kind, double amount, const Eigen::Vector3d& centre, double radius) {
  Deformation deformation;
  deformation.kind = kind;
  deformation.amount = amount;
  deformation.brush = render::DeformBrush{centre, radius};
  return deformation;
}

std::vector<Object> objects(Size size) {
  Deformation noise;
  noise.kind = DeformKind::noise;
  noise.amount = 1.0;
  noise.wavelength_mm = 5.0;
  std::vector<Object> all{
      {"candle twisted", "candle", 0.42, 41, 60.0, {along_z(DeformKind::twist, 180.0)}},
      {"candle twisted", "candle", 0.42, 59, 60.0, {along_z(DeformKind::twist, 180.0)}},
      {"cube with a bump",
       "cube",
       0.0,
       37,
       40.0,
       {brushed(DeformKind::dent, -8.0, {0.0, 0.0, 20.0}, 12.0)}},
      {"cube in noise", "cube", 0.0, 37, 40.0, {noise}},
      {"ring dented",
       "torus",
       0.34,
       96,
       40.0,
       {brushed(DeformKind::dent, 4.0, {13.2, 0.0, 6.8}, 9.0)}},
      {"rod bent", "cylinder", 0.3, 60, 50.0, {along_z(DeformKind::bend, 100.0)}},
      {"ring in noise", "torus", 0.34, 139, 40.0, {noise}}};
  if (size == Size::quick) all.resize(1);
  return all;
}

render::Scene scene_of(const Object& object) {
  render::SceneObject body;
  body.name = "object";
  body.shape = std::string(object.shape);
  if (object.proportion > 0.0) body.proportion = object.proportion;
  body.size_mm = object.size_mm;
  body.facets_per_size = body.edges_per_size = object.facets;
  body.material = render::published_material("marble");
  render::Scene scene;
  scene.file = "bench";
  scene.objects = {body};
  render::SpotLight spot;
  spot.point = {{60.0, 80.0, 120.0}, render::Colour::Ones(), 150.0};
  spot.cone_deg = 60.0;
  scene.lights = {spot};
  scene.camera.position_mm = {0.0, 0.0, 300.0};
  return scene;
}

double apart(const render::LiveAnswer& one, const render::LiveAnswer& other,
             const Surface& surface) {
  double worst = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    double difference = 0.0, size = 0.0;
    for (std::size_t t = 0; t < surface.size(); ++t) {
      const double exact = other.exitance[0].exitance[c][t];
      difference += surface.area[t] * std::pow(one.exitance[0].exitance[c][t] - exact, 2);
      size += surface.area[t] * exact * exact;
    }
    worst = std::max(worst, std::sqrt(difference / size));
  }
  return worst;
}

struct Timed {
  std::vector<double> whole, shape, light, model, cpu;
};

Json times(const Timed& timed) {
  return {{"ms", median(timed.whole)},
          {"shape_ms", median(timed.shape)},
          {"light_ms", median(timed.light)},
          {"sum_ms", median(timed.model)},
          {"cpu_ms", median(timed.cpu)}};
}

class Frames {
 public:
  Frames(const Object& object, const Request& request)
      : object_(object), scene_(scene_of(object)), live_(scene_, options(request), warnings_) {}

  /// `share` of the deformation; the least time counts where other work is about.
  render::LiveAnswer at(double share, bool moving, FollowBy by) {
    std::vector<Deformation> deform = object_.deform;
    for (Deformation& one : deform) one.amount *= share;
    return live_.answer({scene_.lights, {}, "", {{{0, deform}}, moving, 30.0, by}}, silent_);
  }
  Timed run(int frames, const std::function<render::LiveAnswer(int)>& answer) const {
    Timed timed;
    for (int i = 0; i < frames; ++i) {
      const Stopwatch watch;
      const double before = processor_seconds();
      const render::LiveAnswer got = answer(i);
      timed.cpu.push_back(1e3 * (processor_seconds() - before));
      timed.whole.push_back(watch.milliseconds());
      timed.shape.push_back(got.shape_ms);
      timed.light.push_back(got.light_ms);
      timed.model.push_back(got.model_ms);
    }
    return timed;
  }
  const render::Scene& scene() const { return scene_; }
  const Object& object() const { return object_; }
  const render::World& world() const { return live_.world(); }

  static render::LiveOptions options(const Request& request) {
    render::LiveOptions options;
    options.device = request.device;
    options.model = "dipole-rotated";
    return options;
  }

 private:
  const Object& object_;
  render::Scene scene_;
  std::vector<std::string> warnings_;
  render::LiveScene live_;
  Progress silent_;
};

Json row_of(const Object& object, const Request& request, int repetitions) {
  Frames frames(object, request);
  const auto share = [&](int i) { return 0.5 - 0.5 * std::cos(0.35 * (i + 1)); };
  frames.at(share(-1), true, FollowBy::update);
  const Timed still =
      frames.run(repetitions, [&](int) { return frames.at(share(-1), true, FollowBy::update); });
  const Timed incremental =
      frames.run(repetitions, [&](int i) { return frames.at(share(i), true, FollowBy::update); });
  const render::LiveAnswer last = frames.at(share(repetitions - 1), false, FollowBy::update);
  const Timed anew =
      frames.run(repetitions, [&](int i) { return frames.at(share(i), true, FollowBy::renewal); });
  render::Scene deformed = frames.scene();
  deformed.objects[0].deform = object.deform;
  for (Deformation& one : deformed.objects[0].deform) one.amount *= share(repetitions - 1);
  std::vector<std::string> warnings;
  render::LiveScene fresh(deformed, Frames::options(request), warnings);
  Progress silent;
  const double error =
      apart(last, fresh.answer({deformed.lights, {}}, silent), fresh.world().objects()[0].surface);
  return {
      {"object", object.name},     {"triangles", frames.world().objects()[0].mesh.triangles.size()},
      {"static", times(still)},    {"incremental", times(incremental)},
      {"on_the_fly", times(anew)}, {"frames_per_second", 1e3 / median(incremental.whole)},
      {"from_scratch", error}};
}

}  // namespace

void dipole_deform(const Request& request, Progress& progress, const Save& save) {
  const int repetitions = request.count("repetitions", request.size == Size::quick ? 3 : 15);
  Json rows = Json::array();
  for (const Object& object : objects(request.size)) {
    progress.update("bench dipole", 0.5, object.name);
    rows.push_back(row_of(object, request, repetitions));
    save({{"repetitions", repetitions}, {"rows", rows}});
  }
}

}  // namespace kappamu::studies
