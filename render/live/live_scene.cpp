#include "render/live/live_scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/processor_time.h"
#include "forward/registry.h"
#include "render/light/beam_places.h"
#include "render/light/incident_light.h"
#include "render/light/inner_light.h"
#include "render/live/object_solver.h"

namespace kappamu::render {

namespace {

/// Of the environment's light in the first answer.
constexpr double preview_rays = 0.05 * environment_rays;

/// Whether models see the same, though it was made twice.
bool same(const ObjectMedia& a, const ObjectMedia& b) {
  for (std::size_t c = 0; c < 3; ++c) {
    const ObjectMedium &one = *a.channels[c], &other = *b.channels[c];
    if (&one == &other) continue;
    if (!one.homogeneous() || !other.homogeneous()) return false;
    const Coefficients here = one.smallest(), there = other.smallest();
    if (here.kappa != there.kappa || here.mu != there.mu) return false;
  }
  return true;
}

}  // namespace

LiveScene::LiveScene(const Scene& scene, const LiveOptions& options,
                     std::vector<std::string>& warnings, const ShapesKnown& shapes_known)
    : world_(scene, warnings, shapes_known),
      shapes_(scene),
      options_(options),
      tolerance_(options.tolerance.value_or(scene.model.tolerance)),
      chosen_(options.model),
      sky_(world_.objects().size()),
      below_(world_.objects().size()),
      arriving_(world_.objects().size()),
      homogeneous_(all_homogeneous(world_)),
      lit_inside_(world_.lit_inside()),
      furry_(std::any_of(scene.objects.begin(), scene.objects.end(),
                         [](const SceneObject& object) { return object.fur.has_value(); })) {}

LiveScene::~LiveScene() = default;

void LiveScene::show(const LiveAnswer& answer) {
  for (const auto& [object, vertices] : answer.moved) world_.move(object, vertices);
}

void LiveScene::take_media(const LiveQuestion& question) {
  bool changed = false, refracts_otherwise = false;
  for (const auto& [object, media] : question.media) {
    const WorldObject& edited = solved().objects()[object];
    const double eta = edited.boundary.eta;
    const bool other = !same(edited.media, media);
    if (other) below_[object].reset();
    changed = changed || other;
    ObjectMedia set = media;
    if (!other) set.channels = edited.media.channels;
    solved().set_media(object, std::move(set));
    refracts_otherwise = refracts_otherwise || edited.boundary.eta != eta;
  }
  if (!changed && !refracts_otherwise) return;
  features_.clear();
  refused_.clear();
  impossible_.clear();
  const bool homogeneous = all_homogeneous(solved());
  // Where objects are homogeneous again, their models are tried as at the start.
  if (!std::exchange(homogeneous_, homogeneous) && homogeneous) records_.clear();
  std::erase_if(solvers_, [&](const auto& one) {
    const bool answers = homogeneous || forward::object_model(one.first).can.heterogeneous;
    return refracts_otherwise || !answers;
  });
}

/// Which lights are inside objects depends on the shapes.
void LiveScene::take_lights() {
  solved().set_lights(lights_);
  if (std::exchange(lit_inside_, solved().lit_inside()) == lit_inside_) return;
  features_.clear();
  refused_.clear();
  impossible_.clear();
}

/// Why the model does not answer; empty: it does.
std::string LiveScene::take_model(const std::string& model, Progress& progress) {
  if (model.empty() || model == chosen_) return "";
  if (solvers_of(model, progress) != nullptr) {
    chosen_ = model;
    return "";
  }
  const std::string refused = refused_.at(model);
  refused_.erase(model);
  return refused;
}

/// Answers are of a world of their own from now on. The model that will answer is made before
/// shapes move, so that it can follow.
void LiveScene::part_worlds(Progress& progress) {
  solved_ = std::make_unique<World>(world_);
  solvers_.clear();
  if (last_) first_step(progress);
}

/// Why shapes are as they were; empty: they are those asked for.
std::string LiveScene::take_shapes(const ShapeQuestion& shape) {
  std::string refused;
  const std::vector<std::size_t> others = shapes_.set(shape, solved(), refused);
  if (others.empty()) return refused;
  for (const auto& [model, solvers] : solvers_) {
    for (const std::size_t object : others) solvers[object]->shape_changed();
  }
  // What is known is of another shape.
  for (const std::size_t object : others) below_[object].reset();
  for (auto& of_object : arriving_) of_object.reset();
  features_.clear();
  std::erase_if(records_, [](const auto& record) { return record.first.second > 0; });
  for (auto& [step, record] : records_) record.error.reset();
  if (shapes_.any_moves()) return refused;
  refused_.clear();
  impossible_.clear();
  sky_.reset();
  return refused;
}

void LiveScene::light_environment(double rays, Progress& progress) {
  sky_.find(solved(), lights_, rays, options_.seed, progress);
}

/// What stays while a light turns comes first.
std::vector<forward::LightOfChannels> LiveScene::light_objects(const Solvers& solvers, int level,
                                                               const LightSources& sources,
                                                               Progress& progress) {
  const World& world = solved();
  std::vector<forward::LightOfChannels> incident(world.objects().size());
  for (std::size_t i = 0; i < incident.size(); ++i) {
    const bool moves = shapes_.moves(i);
    std::vector<BeamPlace> places = level == 0 ? solvers[i]->places() : std::vector<BeamPlace>();
    if (places.empty()) {
      places = moves ? middles_of(world.objects()[i]) : incident_places(world.objects()[i]);
    }
    const std::array<BeamsOfChannels, 3> beams{
        sky_.lamps(world, i, places, moves, progress), inner_beams(world, i, options_.seed),
        beams_of_lights(world, i, sources, nullptr, places, options_.seed, progress,
                        environment_rays)};
    for (std::size_t c = 0; c < 3; ++c) {
      for (const BeamsOfChannels& some : beams) {
        incident[i][c].beams.insert(incident[i][c].beams.end(), some[c].begin(), some[c].end());
      }
      incident[i][c].diffuse = sky_.diffuse(i)[c];
    }
  }
  return incident;
}

LiveAnswer LiveScene::solve(const Step& step, Progress& progress) {
  const auto& [model, level] = step;
  const Solvers& solvers = solvers_.at(model);
  LiveAnswer answer;
  answer.model = model;
  answer.level = level;
  const Stopwatch light_watch;
  const World& world = solved();
  const LightSources sources = make_light_sources(world.outer_lights());
  std::vector<forward::LightOfChannels> incident = light_objects(solvers, level, sources, progress);
  answer.light_ms = light_watch.milliseconds();
  const Stopwatch model_watch;
  std::optional<double> stated;
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    ObjectSolver::Answer solved = solvers[i]->solve(incident[i], level, progress);
    if (solved.error) stated = std::max(stated.value_or(0.0), *solved.error);
    answer.iterations = std::max(answer.iterations, solved.iterations);
    answer.residual = std::max(answer.residual, solved.residual);
    answer.converged = answer.converged && solved.converged;
    answer.elements += solved.elements;
    answer.caught_up = answer.caught_up && !solvers[i]->is_behind();
    answer.exitance.push_back({std::move(solved.exitance), sky_.diffuse(i)});
  }
  answer.model_ms = model_watch.milliseconds();
  describe_surfaces(sources, answer);
  incident_ = std::move(incident);
  Record& record = records_[step];
  const double milliseconds = answer.light_ms + answer.model_ms;
  record.milliseconds =
      record.milliseconds > 0.0 ? std::min(record.milliseconds, milliseconds) : milliseconds;
  if (stated) record.error = stated;
  answer.error_estimate = record.error;
  answer.model_error = model_error(model);
  return answer;
}

void LiveScene::describe_surfaces(const LightSources& sources, LiveAnswer& answer) {
  const Stopwatch watch;
  const World& world = solved();
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    const WorldObject& object = world.objects()[i];
    if (!below_[i]) below_[i] = std::make_shared<const BelowSurface>(below_surface(object));
    if (!arriving_[i]) arriving_[i] = arriving_on(world, i, sources);
    answer.surface.push_back({object.boundary, object.roughness, below_[i], *arriving_[i]});
  }
  for (std::size_t s = 0; s < std::min(most_drawn_sources, sources.size()); ++s) {
    Eigen::Vector4d place = Eigen::Vector4d::UnitW();
    if (const Eigen::Vector3d* position = sources[s]->position()) {
      place.head<3>() = *position;
    } else {
      place << -sources[s]->at(Eigen::Vector3d::Zero()).direction, 0.0;
    }
    answer.sources.push_back(place);
  }
  answer.surface_ms = watch.milliseconds();
}

LiveAnswer LiveScene::answer(const LiveQuestion& question, Progress& progress) {
  answered_ = false;
  picture_.reset();
  take_media(question);
  if (!std::equal(lights_.begin(), lights_.end(), question.lights.begin(), question.lights.end(),
                  [](const Light& a, const Light& b) { return same(a, b); })) {
    for (auto& of_object : arriving_) of_object.reset();
  }
  lights_ = question.lights;
  const Stopwatch shape_watch;
  mode_ = "static";
  asked_shape_ = question.shape;
  if (!solved_ && shapes_.differ_from(question.shape)) part_worlds(progress);
  take_lights();
  std::string refused = take_model(question.model, progress);
  const std::string shape_refused = take_shapes(question.shape);
  take_lights();  // an object may have moved about a light, or from it
  const Step step = answering_step(progress, refused);
  const double shape_ms = shape_watch.milliseconds();
  light_environment(preview_rays, progress);
  LiveAnswer answer = solve(step, progress);
  answer.refused = refused;
  last_ = answer;
  answered_ = true;
  answer.shape_refused = shape_refused;
  answer.moved = shapes_.take_moved(solved());
  answer.mode = !answer.moved.empty() && mode_ == "static" ? anew_mode : mode_;
  if (answer.mode != "static") answer.shape_ms = shape_ms;
  return answer;
}

/// Of the answer that was just given at a step, by the one before it where that is of the level
/// before.
void LiveScene::state_errors(const Step& step, LiveAnswer& answer) {
  std::optional<double> worst;
  const bool follows = last_ && last_->model == step.first && last_->level + 1 == step.second;
  for (std::size_t i = 0; i < answer.exitance.size(); ++i) {
    const auto error = solvers_.at(step.first)[i]->measured_error(
        incident_[i], step.second, answer.exitance[i].exitance,
        follows ? last_->exitance[i].exitance : forward::ExitanceOfChannels());
    if (error) worst = std::max(worst.value_or(0.0), *error);
  }
  if (!worst) return;
  records_[step].error = answer.error_estimate = worst;
  // The finer answer errs by what two levels differ by at least.
  constexpr double of_level_before = 2.5;
  if (follows) records_[{last_->model, last_->level}].error = of_level_before * *worst;
}

std::optional<Picture> LiveScene::traced(const PictureView& view, Progress& progress) {
  if (!answered_ || shapes_.any_moves() || furry_) return std::nullopt;
  return picture_.next(solved(), sky_.environment(), last_->exitance, view, options_.seed,
                       progress);
}

std::optional<LiveAnswer> LiveScene::refined(Progress& progress) {
  if (!answered_ || shapes_.any_moves()) return std::nullopt;
  picture_.reset();
  if (features_.empty()) {
    const Solvers& solvers = solvers_.at(last_->model);
    for (std::size_t i = 0; i < solvers.size(); ++i) {
      features_.push_back(solvers[i]->features(incident_[i]));
    }
    last_->model_error = model_error(last_->model);
    return last_;
  }
  const bool preview = sky_.is_preview();
  if (preview) light_environment(environment_rays, progress);
  while (const std::optional<Step> next = next_step(progress)) {
    try {
      LiveAnswer answer = solve(*next, progress);
      answer.refused = last_->refused;
      state_errors(*next, answer);
      last_ = std::move(answer);
      return last_;
    } catch (const InputError&) {
      impossible_.insert(*next);
    }
  }
  const Step same_step{last_->model, last_->level};
  if (preview) {
    last_ = solve(same_step, progress);
    return last_;
  }
  if (last_->error_estimate) return std::nullopt;
  state_errors(same_step, *last_);
  if (!last_->error_estimate) return std::nullopt;
  return last_;
}

}  // namespace kappamu::render
