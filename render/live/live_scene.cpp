#include "render/live/live_scene.h"

#include <algorithm>

#include "core/error.h"
#include "core/processor_time.h"
#include "forward/block/block_grid.h"
#include "forward/live_model.h"
#include "forward/registry.h"
#include "render/light/beam_places.h"
#include "render/light/incident_light.h"

namespace kappamu::render {

namespace {

using forward::ChannelProblems;
using forward::ExitanceOfChannels;
using forward::LightOfChannels;

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

namespace {

bool can_answer(const forward::ModelDescription& model, const World& world) {
  return (model.can.heterogeneous || all_homogeneous(world)) &&
         (model.can.any_shape || all_blocks(world));
}

}  // namespace

std::vector<std::string> live_models(const World& world) {
  std::vector<std::string> models, general;
  for (const forward::ModelDescription& model : forward::object_models()) {
    if (!model.can.live || !can_answer(model, world)) continue;
    const bool special = !model.can.heterogeneous || !model.can.any_shape;
    (special ? models : general).push_back(model.name);
  }
  models.insert(models.end(), general.begin(), general.end());
  return models;
}

/// One object's model, and what it keeps from light to light, if anything.
struct LiveScene::Solver {
  Solver(const WorldObject& lit, const std::string& name, const OptionValues& parameters,
         const LiveOptions& asked)
      : object{lit.mesh, lit.surface, *lit.rays, lit.media.channels, lit.boundary.eta, lit.drawn()},
        model(forward::make_object_model(name, forward::ModelError::left_out, parameters)) {
    options.device = asked.device;
    options.seed = asked.seed;
    options.tolerance = asked.tolerance.value_or(usual_tolerance);
    kept = model->keep(object, options);
    if (kept && kept->beam_spacing_mm() > 0.0) {
      places = beam_places(lit, {kept->beam_spacing_mm(), kept->beam_spacing_mm()});
    }
  }

  ExitanceOfChannels solve(const LightOfChannels& light, LiveAnswer& answer, Progress& progress) {
    const Stopwatch watch;
    if (!kept) {
      ExitanceOfChannels exitance = solve_anew(light, answer, progress);
      answer.model_ms += watch.milliseconds();
      return exitance;
    }
    forward::LiveModel::Answer solved = kept->solve(light);
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
        model->solve_channels(problems.all(), options, progress);
    ExitanceOfChannels exitance;
    for (std::size_t c = 0; c < 3; ++c) {
      exitance[c] = std::move(results[c].exitance);
      answer.error_estimate = std::max(answer.error_estimate, results[c].error_estimate[0]);
      answer.iterations = std::max(answer.iterations, results[c].iterations);
      answer.converged = answer.converged && results[c].converged;
    }
    return exitance;
  }

  forward::LiveBody object;
  std::unique_ptr<forward::ObjectModel> model;
  forward::ObjectOptions options;
  std::unique_ptr<forward::LiveModel> kept;
  std::vector<BeamPlace> places;   ///< of a model that says how far apart
  std::optional<double> measured;  ///< error of the first answer
};

LiveScene::LiveScene(const Scene& scene, const LiveOptions& options,
                     std::vector<std::string>& warnings)
    : world_(scene, warnings), options_(options) {
  start(options.model ? *options.model : live_models(world_).front(), options.parameters);
  const std::optional<Environment> environment = make_environment(scene.lights);
  Progress silent;
  for (std::size_t i = 0; i < world_.objects().size(); ++i) {
    diffuse_.emplace_back();
    if (!environment) continue;
    IncidentLight light = incident_light(world_, i, {}, &*environment, options.seed, silent);
    for (std::size_t c = 0; c < 3; ++c) {
      diffuse_.back()[c] = std::move(light.channels[c].diffuse);
    }
  }
}

LiveScene::~LiveScene() = default;

void LiveScene::start(const std::string& model, const OptionValues& parameters) {
  std::vector<std::unique_ptr<Solver>> solvers;
  for (const WorldObject& object : world_.objects())
    solvers.push_back(std::make_unique<Solver>(object, model, parameters, options_));
  solvers_ = std::move(solvers);
  model_ = model;
}

void LiveScene::set_media(std::size_t object, const ObjectMedia& media) {
  const double eta = world_.objects()[object].boundary.eta;
  world_.set_media(object, media);
  if (world_.objects()[object].boundary.eta == eta) return;
  solvers_[object] =
      std::make_unique<Solver>(world_.objects()[object], model_, options_.parameters, options_);
}

LiveAnswer LiveScene::answer(const LiveQuestion& question, Progress& progress) {
  for (const auto& [object, media] : question.media) set_media(object, media);
  LiveAnswer answer;
  if (!can_answer(forward::object_model(model_), world_)) start(live_models(world_).front(), {});
  if (!question.model.empty() && question.model != model_) {
    try {
      if (!can_answer(forward::object_model(question.model), world_)) {
        throw InputError("model " + question.model + " does not answer for these objects; " +
                         model_ + " does");
      }
      start(question.model, {});
    } catch (const InputError& refusal) {
      answer.refused = refusal.what();
    }
  }
  answer.model = model_;
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
