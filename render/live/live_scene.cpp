#include "render/live/live_scene.h"

#include <algorithm>

#include "core/processor_time.h"
#include "forward/block/block_grid.h"
#include "forward/object_models.h"
#include "render/light/beam_places.h"
#include "render/light/incident_light.h"
#include "render/live/live_object.h"

namespace kappamu::render {

namespace {

/// Relative error that a model which refines is asked for, coarse for the sake of time.
constexpr double usual_tolerance = 0.1;

bool all_homogeneous(const World& world) {
  return std::all_of(world.objects().begin(), world.objects().end(), [](const WorldObject& object) {
    return std::all_of(object.media.channels.begin(), object.media.channels.end(),
                       [](const auto& medium) { return medium->homogeneous(); });
  });
}

bool all_blocks(const World& world) {
  return std::all_of(world.objects().begin(), world.objects().end(), [](const WorldObject& object) {
    return std::all_of(object.media.channels.begin(), object.media.channels.end(),
                       [&](const auto& medium) {
                         return forward::block::block_grid(object.mesh, *medium).has_value();
                       });
  });
}

}  // namespace

/// One object's model: what it keeps from light to light, or a model that starts anew.
struct LiveScene::Solver {
  Solver(const WorldObject& lit, const std::string& name, const LiveOptions& asked) : object(lit) {
    options.device = asked.device;
    options.seed = asked.seed;
    options.tolerance = asked.tolerance.value_or(usual_tolerance);
    kept = make_live_object(name, lit, options);
    if (!kept) model = forward::make_object_model(name, forward::ModelError::left_out);
    if (kept && kept->beam_spacing_mm() > 0.0) {
      places = beam_places(lit, {kept->beam_spacing_mm(), kept->beam_spacing_mm()});
    }
  }

  ExitanceOfChannels solve(const LightOfChannels& light, LiveAnswer& answer, Progress& progress) {
    const Stopwatch watch;
    if (model) {
      ExitanceOfChannels exitance = solve_anew(light, answer, progress);
      answer.model_ms += watch.milliseconds();
      return exitance;
    }
    LiveObject::Answer solved = kept->solve(light);
    answer.model_ms += watch.milliseconds();
    answer.iterations = std::max(answer.iterations, solved.iterations);
    answer.residual = std::max(answer.residual, solved.residual);
    answer.converged = answer.converged && solved.converged;
    if (!measured) measured = kept->measured_error(light, solved.exitance);
    answer.error_estimate = std::max(answer.error_estimate, *measured);
    return std::move(solved.exitance);
  }

  ExitanceOfChannels solve_anew(const LightOfChannels& light, LiveAnswer& answer,
                                Progress& progress) {
    const ChannelProblems problems(object, light);
    std::vector<forward::ObjectResult> results =
        model->solve_channels(problems.of, options, progress);
    ExitanceOfChannels exitance;
    for (std::size_t c = 0; c < 3; ++c) {
      exitance[c] = std::move(results[c].exitance);
      answer.error_estimate = std::max(answer.error_estimate, results[c].error_estimate[0]);
      answer.iterations = std::max(answer.iterations, results[c].iterations);
      answer.converged = answer.converged && results[c].converged;
    }
    return exitance;
  }

  const WorldObject& object;
  forward::ObjectOptions options;
  std::unique_ptr<LiveObject> kept;
  std::vector<BeamPlace> places;   ///< of a model that says how far apart
  std::optional<double> measured;  ///< error of the first answer
  std::unique_ptr<forward::ObjectModel> model;
};

LiveScene::LiveScene(const Scene& scene, const LiveOptions& options,
                     std::vector<std::string>& warnings)
    : world_(scene, warnings), options_(options) {
  model_name_ = options.model.value_or(all_blocks(world_)        ? "grid"
                                       : all_homogeneous(world_) ? "dipole-rotated"
                                                                 : "embedded");
  const std::optional<Environment> environment = make_environment(scene.lights);
  Progress silent;
  for (std::size_t i = 0; i < world_.objects().size(); ++i) {
    solvers_.push_back(std::make_unique<Solver>(world_.objects()[i], model_name_, options));
    diffuse_.emplace_back();
    if (!environment) continue;
    IncidentLight light = incident_light(world_, i, {}, &*environment, options.seed, silent);
    for (std::size_t c = 0; c < 3; ++c) {
      diffuse_.back()[c] = std::move(light.channels[c].diffuse);
    }
  }
}

LiveScene::~LiveScene() = default;

LiveAnswer LiveScene::answer(const LiveQuestion& question, Progress& progress) {
  for (const auto& [object, media] : question.media) world_.set_media(object, media);
  LiveAnswer answer;
  const Stopwatch watch;
  const LightSources sources = make_light_sources(question.lights);
  std::vector<LightOfChannels> incident;
  for (std::size_t i = 0; i < world_.objects().size(); ++i) {
    const std::vector<BeamPlace>& places = solvers_[i]->places;
    incident.push_back(
        places.empty()
            ? incident_light(world_, i, sources, nullptr, options_.seed, progress).channels
            : beams_at(world_, i, sources, places));
    for (std::size_t c = 0; c < 3; ++c) incident[i][c].diffuse = diffuse_[i][c];
  }
  answer.light_ms = watch.milliseconds();
  for (std::size_t i = 0; i < world_.objects().size(); ++i) {
    ObjectExitance exitance;
    exitance.diffuse = diffuse_[i];
    exitance.exitance = solvers_[i]->solve(incident[i], answer, progress);
    answer.exitance.push_back(std::move(exitance));
  }
  return answer;
}

}  // namespace kappamu::render
