#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/processor_time.h"
#include "forward/embedded/embedded_model.h"
#include "forward/embedded/geometry/cut_mesh.h"
#include "render/render_scene.h"
#include "render/scene/world.h"
#include "studies/objects/object_bench.h"
#include "studies/objects/object_measurement.h"

namespace kappamu::studies {

namespace {

constexpr int repetitions = 3;
/// [T] Table 4.1 has its dragon on 256³.
constexpr int thesis_level = 8;

/// Model `embedded`, and how long its linear systems took, of all channels and meshes.
class TimedEmbedded : public forward::ChannelsModel {
 public:
  std::vector<forward::ObjectResult> solve_channels(
      std::span<const forward::ObjectProblem> problems, const forward::ObjectOptions& options,
      Progress& progress) override {
    auto results = forward::EmbeddedModel().solve_channels(problems, options, progress);
    solving_ = results.front().seconds;
    lights_ = 0;
    for (const forward::ObjectProblem& problem : problems) lights_ += problem.lights.size();
    return results;
  }
  double seconds_per_light() const { return solving_ / static_cast<double>(lights_); }

 private:
  double solving_ = 0.0;
  std::size_t lights_ = 0;
};

std::size_t cubes_of_thesis(const render::Scene& scene) {
  std::vector<std::string> warnings;
  const render::World world(scene, warnings);
  const render::WorldObject& object = world.objects().front();
  forward::embedded::Octree tree(object.mesh);
  tree.refine_surface(thesis_level);
  return forward::embedded::cut_mesh(tree, object.mesh, *object.rays).cubes.size();
}

Json timed_picture(const render::Scene& scene, const Request& request, Progress& progress) {
  TimedEmbedded model;
  const Stopwatch watch;
  const render::RenderResult result =
      render::render_scene(scene, model, {request.device, request.seed}, progress);
  const auto folder = request.folder / ("picture-" + scene.objects.front().name);
  std::filesystem::create_directories(folder);
  render::write_render(result, scene, {request.device, request.seed}, folder);
  const render::ChannelReport& green = result.objects.front().channels[1];
  double stated = 0.0;
  for (const render::ChannelReport& channel : result.objects.front().channels) {
    stated = std::max(stated, channel.error_estimate);
  }
  return {{"seconds", watch.seconds()},
          {"scene_seconds", result.scene_seconds},
          {"light_seconds", result.light_seconds},
          {"model_seconds", result.model_seconds},
          {"picture_seconds", result.picture_seconds},
          {"seconds_per_light", model.seconds_per_light()},
          {"elements", green.elements},
          {"error_estimate", stated}};
}

}  // namespace

void measure_pictures(const Request& request, Progress& progress, const Save& save) {
  std::vector<render::Scene> scenes{render::read_scene("scenes/nefertiti-marble.json")};
  for (const std::string& file : request.words("mesh")) {
    scenes.push_back(scenes.front());
    scenes.back().objects.front().shape = std::filesystem::absolute(file);
    scenes.back().objects.front().name = std::filesystem::path(file).stem();
  }
  std::vector<double> tolerances{0.01, 0.0075, 0.005};
  if (request.has("tolerance")) tolerances = {request.number("tolerance", 0.01)};
  if (request.size != Size::full) {
    tolerances = {0.1};
    for (render::Scene& scene : scenes) scene.film.samples = 1;
  }
  Json rows = Json::array();
  for (render::Scene& scene : scenes) {
    const std::size_t even = cubes_of_thesis(scene);
    for (const double tolerance : tolerances) {
      scene.model.tolerance = tolerance;
      std::vector<Json> times;
      for (int k = 0; k < (request.size == Size::full ? repetitions : 1); ++k) {
        times.push_back(timed_picture(scene, request, progress));
      }
      std::sort(times.begin(), times.end(),
                [](const Json& a, const Json& b) { return a["seconds"] < b["seconds"]; });
      Json row = times[times.size() / 2];
      row["name"] = scene.objects.front().name;
      row["tolerance"] = tolerance;
      row["cubes_of_256"] = even;
      rows.push_back(std::move(row));
      save({{"rows", rows}});
    }
  }
}

}  // namespace kappamu::studies
