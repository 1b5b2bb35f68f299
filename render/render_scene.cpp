#include "render/render_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>

#include "core/error.h"
#include "core/process_memory.h"
#include "core/shown_text.h"
#include "forward/model_error.h"
#include "render/fur/fur_shading.h"
#include "render/light/incident_light.h"
#include "render/scene/composed_field.h"
#include "render/scene/world.h"

namespace kappamu::render {

namespace {

constexpr std::array<const char*, 3> channel_names{"R", "G", "B"};

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

bool equal(const forward::ObjectLight& one, const forward::ObjectLight& other) {
  return one.diffuse == other.diffuse &&
         std::equal(one.beams.begin(), one.beams.end(), other.beams.begin(), other.beams.end(),
                    [](const forward::Beam& a, const forward::Beam& b) {
                      return a.triangle == b.triangle && a.power == b.power &&
                             a.position == b.position && a.direction == b.direction;
                    });
}

/// Lights of one medium without repetition, and the light of each channel that has the medium.
struct Batch {
  std::vector<forward::ObjectLight> lights;
  std::vector<std::pair<std::size_t, std::size_t>> light_of_channel;  ///< channel, light
};

std::vector<Batch> batches_of(const WorldObject& object, const IncidentLight& light) {
  std::vector<Batch> batches;
  for (std::size_t c = 0; c < 3; ++c) {
    auto batch = std::find_if(batches.begin(), batches.end(), [&](const Batch& made) {
      return object.media.channels[made.light_of_channel[0].first] == object.media.channels[c];
    });
    if (batch == batches.end()) batch = batches.emplace(batches.end());
    const auto found = std::find_if(
        batch->lights.begin(), batch->lights.end(),
        [&](const forward::ObjectLight& seen) { return equal(seen, light.channels[c]); });
    batch->light_of_channel.emplace_back(c, found - batch->lights.begin());
    if (found == batch->lights.end()) batch->lights.push_back(light.channels[c]);
  }
  return batches;
}

class ObjectSolve {
 public:
  ObjectSolve(const WorldObject& object, const IncidentLight& light, const Scene& scene,
              const RenderOptions& options, forward::ObjectModel& model)
      : object_(object), light_(light), model_(model) {
    options_.tolerance = scene.model.tolerance;
    options_.follow_reentry = scene.model.follow_reentry;
    options_.max_elements = scene.model.max_elements;
    options_.device = options.device;
    options_.seed = options.seed;
    options_.costs = options.costs;
    options_.eye = object.world_from_object.inverse() * scene.camera.position_mm;
  }

  ObjectExitance solve(ObjectReport& report, std::vector<std::string>& warnings,
                       Progress& progress) {
    ObjectExitance exitance;
    for (std::size_t c = 0; c < 3; ++c) exitance.diffuse[c] = light_.channels[c].diffuse;
    const std::vector<Batch> batches = batches_of(object_, light_);
    std::vector<forward::ObjectProblem> problems;
    for (const Batch& batch : batches) {
      problems.push_back({object_.mesh, object_.surface, *object_.rays,
                          *object_.media.channels[batch.light_of_channel[0].first],
                          object_.boundary.eta, batch.lights, object_.drawn()});
    }
    const std::vector<forward::ObjectResult> results =
        model_.solve_channels(problems, options_, progress);
    report.candidates = results.front().candidates;
    std::vector<std::pair<std::string, std::string>> warned;  // and the channels of each
    for (std::size_t k = 0; k < batches.size(); ++k) {
      const std::string names = take(batches[k], problems[k], results[k], exitance, report);
      for (const std::string& warning : results[k].warnings) {
        const auto known = std::find_if(warned.begin(), warned.end(),
                                        [&](const auto& one) { return one.first == warning; });
        if (known == warned.end()) {
          warned.emplace_back(warning, names);
        } else {
          known->second += names;
        }
      }
    }
    for (const auto& [warning, names] : warned) {
      warnings.push_back("object '" + object_.name + "', " + names + ": " + warning);
    }
    return exitance;
  }

 private:
  /// The channels' names.
  std::string take(const Batch& batch, const forward::ObjectProblem& problem,
                   const forward::ObjectResult& result, ObjectExitance& exitance,
                   ObjectReport& report) const {
    const auto samples = static_cast<std::ptrdiff_t>(object_.surface.size());
    std::string names;
    for (const auto& [channel, light] : batch.light_of_channel) {
      const auto first = result.exitance.begin() + static_cast<std::ptrdiff_t>(light) * samples;
      exitance.exitance[channel].assign(first, first + samples);
      names += channel_names[channel];
      ChannelReport& to = report.channels[channel];
      to.power_in = light_.power[static_cast<Eigen::Index>(channel)];
      to.balance = result.balance[light];
      to.error = result.error(light);
      to.error_estimate = result.error_estimate[light];
      to.error_map = forward::error_map(problem, result, light);
      double power = 0.0;
      for (std::size_t t = 0; t < to.error_map.size(); ++t) {
        const double leaving = object_.surface.area[t] * exitance.exitance[channel][t];
        power += leaving;
        to.mean_error += leaving * to.error_map[t];
        to.max_error = std::max(to.max_error, to.error_map[t]);
      }
      if (power > 0.0) to.mean_error /= power;
      to.elements = result.elements;
      to.iterations = result.iterations;
      to.converged = result.converged;
      to.message = result.message;
    }
    return names;
  }

  const WorldObject& object_;
  const IncidentLight& light_;
  forward::ObjectModel& model_;
  forward::ObjectOptions options_;
};

void append_samples(const WorldObject& object, const ObjectExitance& exitance,
                    RenderResult& result) {
  for (std::size_t t = 0; t < object.surface.size(); ++t) {
    const Eigen::Vector3d position = object.world_from_object * object.surface.position[t];
    const Eigen::Vector3d normal = object.world_from_object.rotation * object.surface.normal[t];
    for (int i = 0; i < 3; ++i) result.surface.push_back(static_cast<float>(position[i]));
    for (int i = 0; i < 3; ++i) result.surface.push_back(static_cast<float>(normal[i]));
    result.surface.push_back(static_cast<float>(object.surface.area[t]));
    for (std::size_t c = 0; c < 3; ++c) {
      result.exitance[c].push_back(static_cast<float>(exitance.exitance[c][t]));
    }
  }
}

}  // namespace

namespace {

/// Throws before the work where the film does not fit the memory, and states what it needs.
std::string film_memory(const Scene& scene) {
  const double bytes = picture_memory(scene.film);
  if (bytes > usable_memory()) {
    throw InputError(scene.file.string() + ": film of " + std::to_string(scene.film.width) + " x " +
                     std::to_string(scene.film.height) + " pixels needs " + gigabytes(bytes) +
                     " of memory and this machine has " + gigabytes(main_memory()) +
                     "; make it smaller");
  }
  return "film: " + gigabytes(bytes);
}

/// Where a camera sees nothing: its aim is named, and a place where it would see the first object.
void warn_of_an_empty_picture(const Picture& picture, const World& world, const Camera& camera,
                              std::vector<std::string>& warnings) {
  const std::vector<float>& covered = picture.coverage.values();
  if (std::any_of(covered.begin(), covered.end(), [](float share) { return share > 0.0F; })) return;
  const WorldObject& first = world.objects().front();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& corner : first.mesh.vertices) {
    box.extend(first.world_from_object * corner);
  }
  const Eigen::Vector3d c = box.center(), at = camera.target_mm;
  warnings.push_back(
      formatted("no pixel shows an object: the camera looks at (%.3g, %.3g, %.3g) mm, and ", at[0],
                at[1], at[2]) +
      "object '" + first.name +
      formatted("' lies about (%.3g, %.3g, %.3g) mm; change 'camera.target_mm'", c[0], c[1], c[2]));
}

}  // namespace

RenderResult render_scene(const Scene& scene, forward::ObjectModel& model,
                          const RenderOptions& options, Progress& progress) {
  Stopwatch watch;
  RenderResult result;
  progress.update("scene", 0.0, film_memory(scene));
  expect_wrap_memory(scene, progress);
  const World world(scene, result.warnings);
  const LightSources sources = make_light_sources(world.outer_lights());
  const std::optional<Environment> environment =
      make_environment(scene.lights, LampsEnter::as_beams);
  progress.update("scene", 1.0, "");
  result.scene_seconds = watch.lap();

  std::vector<ObjectExitance> exitance;
  Furs furs(world.objects().size());
  FurTiles tiles;
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    const WorldObject& object = world.objects()[i];
    IncidentLight light = incident_light(world, i, sources, environment ? &*environment : nullptr,
                                         options.seed, progress);
    ObjectReport report;
    if (scene.objects[i].fur) {
      furs[i] = std::make_unique<FurryObject>(object, *scene.objects[i].fur, tiles,
                                              report.fur.emplace(), progress);
      furs[i]->warn(sources, scene.camera.position_mm, result.warnings);
      furs[i]->set_light(world, sources, environment ? &*environment : nullptr);
      furs[i]->shade(light);
    }
    result.light_seconds += watch.lap();
    report.name = object.name;
    report.material = object.media.source;
    report.eta = object.boundary.eta;
    report.first_sample = result.exitance[0].size();
    report.samples = object.surface.size();
    exitance.push_back(
        ObjectSolve(object, light, scene, options, model).solve(report, result.warnings, progress));
    append_samples(object, exitance.back(), result);
    for (const ChannelReport& channel : report.channels) {
      if (!channel.converged) result.converged = false;
    }
    result.objects.push_back(std::move(report));
    result.model_seconds += watch.lap();
  }

  const std::unique_ptr<Shading> shading =
      make_shading(world, sources, environment ? &*environment : nullptr, exitance,
                   scene.camera.position_mm, furs);
  result.picture = render_picture(*shading, scene.camera, scene.film, options.seed, progress);
  warn_of_an_empty_picture(result.picture, world, scene.camera, result.warnings);
  result.exposure = scene.film.exposure.value_or(usual_exposure(result.picture));
  result.picture_seconds = watch.lap();
  return result;
}

}  // namespace kappamu::render
