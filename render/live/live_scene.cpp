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
  Solver(const WorldObject& of, const std::string& name, const OptionValues& parameters,
         const LiveOptions& asked)
      : lit(of),
        object{lit.mesh, lit.surface, *lit.rays, lit.media.channels, lit.boundary.eta, lit.drawn()},
        model(forward::make_object_model(name, forward::ModelError::left_out, parameters)) {
    options.device = asked.device;
    options.seed = asked.seed;
    options.tolerance = asked.tolerance.value_or(usual_tolerance);
    keep();
  }

  void keep() {
    kept = model->keep(object, options);
    place_beams();
  }

  void place_beams() {
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
    if (!measured && middles.empty()) measured = kept->measured_error(light, solved.exitance);
    answer.error_estimate = std::max(answer.error_estimate, measured.value_or(0.0));
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

  /// The object's shape is another.
  void follow(const ShapeQuestion& shape, LiveAnswer& answer) {
    measured.reset();
    middles = shape.moving ? middles_of(lit) : std::vector<BeamPlace>();
    const double most_ms = shape.moving ? shape.most_ms : std::numeric_limits<double>::infinity();
    if (!kept) return;
    answer.mode = "incremental";
    if (shape.by == FollowBy::renewal || !kept->follow(most_ms)) {
      keep();
      answer.mode = "on the fly";
    }
    answer.caught_up = answer.caught_up && kept->caught_up();
    place_beams();
  }

  bool caught_up() const { return !kept || kept->caught_up(); }

  const WorldObject& lit;
  forward::LiveBody object;
  std::unique_ptr<forward::ObjectModel> model;
  forward::ObjectOptions options;
  std::unique_ptr<forward::LiveModel> kept;
  std::vector<BeamPlace> places;   ///< of a model that says how far apart
  std::vector<BeamPlace> middles;  ///< while the shape moves, of a model that does not
  std::optional<double> measured;  ///< error of the first answer
};

LiveScene::LiveScene(const Scene& scene, const LiveOptions& options,
                     std::vector<std::string>& warnings)
    : world_(scene, warnings), options_(options) {
  start(options.model ? *options.model : live_models(world_).front(), options.parameters);
  environment_ = make_environment(scene.lights);
  for (const SceneObject& object : scene.objects) shape_.push_back(object.deform);
  accepted_ = shape_;
  rough_.assign(shape_.size(), 0);
  diffuse_.resize(world_.objects().size());
  for (std::size_t i = 0; i < world_.objects().size(); ++i) light_from_sky(i);
}

void LiveScene::light_from_sky(std::size_t object) {
  if (!environment_) return;
  Progress silent;
  IncidentLight light = incident_light(solved(), object, {}, &*environment_, options_.seed, silent);
  for (std::size_t c = 0; c < 3; ++c) {
    diffuse_[object][c] = std::move(light.channels[c].diffuse);
  }
}

LiveScene::~LiveScene() = default;

void LiveScene::start(const std::string& model, const OptionValues& parameters) {
  std::vector<std::unique_ptr<Solver>> solvers;
  for (const WorldObject& object : solved().objects())
    solvers.push_back(std::make_unique<Solver>(object, model, parameters, options_));
  solvers_ = std::move(solvers);
  model_ = model;
  parameters_ = parameters;
}

void LiveAnswer::take_over(LiveAnswer& earlier) {
  moved.merge(earlier.moved);
  model_changed = model_changed || earlier.model_changed;
  if (shape_refused.empty()) shape_refused = earlier.shape_refused;
}

void LiveScene::show(const LiveAnswer& answer) {
  for (const auto& [object, vertices] : answer.moved) world_.move(object, vertices);
}

void LiveScene::follow(std::size_t object, std::vector<Eigen::Vector3d> vertices,
                       const ShapeQuestion& shape, LiveAnswer& answer) {
  if (!solved_) {
    solved_ = std::make_unique<World>(world_);
    start(model_, OptionValues(parameters_));
  }
  answer.moved[object] = vertices;
  solved_->move(object, std::move(vertices));
  try {
    solvers_[object]->follow(shape, answer);
  } catch (const InputError&) {
    // As a block that is none any more: another model answers.
    start(live_models(*solved_).front(), {});
    answer.model = model_;
    answer.model_changed = true;
    answer.mode = "on the fly";
  }
  rough_[object] = shape.moving ? 1 : 0;
  if (!shape.moving) light_from_sky(object);
}

void LiveScene::set_shapes(const ShapeQuestion& shape, LiveAnswer& answer) {
  const Stopwatch watch;
  for (const auto& [object, asked] : shape.of) {
    const WorldObject& lit = solved().objects()[object];
    const bool rough = rough_[object] != 0 || !solvers_[object]->caught_up();
    if (asked == shape_[object] && (shape.moving || !rough)) continue;
    const TriangleMesh& rest = lit.rest;
    shape_[object] = asked;
    TriangleMesh mesh;
    try {
      const bool known = shape.moving || asked == accepted_[object];
      mesh = known ? deformed(rest, asked) : deformed_body(rest, asked);
      if (!shape.moving) accepted_[object] = asked;
    } catch (const InputError& refusal) {
      answer.shape_refused = "object '" + lit.name + "': " + refusal.what();
      shape_[object] = accepted_[object];
      mesh = deformed(rest, accepted_[object]);
    }
    follow(object, std::move(mesh.vertices), shape, answer);
  }
  answer.shape_ms = watch.milliseconds();
}

void LiveScene::set_media(std::size_t object, const ObjectMedia& media) {
  const WorldObject& edited = solved().objects()[object];
  const double eta = edited.boundary.eta;
  solved().set_media(object, media);
  if (edited.boundary.eta == eta) return;
  solvers_[object] = std::make_unique<Solver>(edited, model_, parameters_, options_);
}

LiveAnswer LiveScene::answer(const LiveQuestion& question, Progress& progress) {
  for (const auto& [object, media] : question.media) set_media(object, media);
  LiveAnswer answer;
  const std::string before = model_;
  if (!can_answer(forward::object_model(model_), solved())) {
    start(live_models(solved()).front(), {});
    answer.model_changed = true;
  }
  const bool gave_way = answer.model_changed && question.model == before;
  if (!question.model.empty() && question.model != model_ && !gave_way) {
    try {
      if (!can_answer(forward::object_model(question.model), solved())) {
        throw InputError("model " + question.model + " does not answer for these objects; " +
                         model_ + " does");
      }
      start(question.model, {});
    } catch (const InputError& refusal) {
      answer.refused = refusal.what();
    }
  }
  answer.model = model_;
  set_shapes(question.shape, answer);
  const World& world = solved();
  const Stopwatch watch;
  const LightSources sources = make_light_sources(question.lights);
  std::vector<LightOfChannels> incident;
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    const Solver& solver = *solvers_[i];
    const std::vector<BeamPlace>& places = solver.places.empty() ? solver.middles : solver.places;
    incident.push_back(
        places.empty()
            ? incident_light(world, i, sources, nullptr, options_.seed, progress).channels
            : beams_at(world, i, sources, places));
    for (std::size_t c = 0; c < 3; ++c) incident[i][c].diffuse = diffuse_[i][c];
  }
  answer.light_ms = watch.milliseconds();
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    ObjectExitance exitance;
    exitance.diffuse = diffuse_[i];
    exitance.exitance = solvers_[i]->solve(incident[i], answer, progress);
    answer.exitance.push_back(std::move(exitance));
  }
  return answer;
}

}  // namespace kappamu::render
