#include "render/live/live_scene.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/processor_time.h"
#include "forward/registry.h"
#include "render/light/beam_places.h"
#include "render/light/incident_light.h"
#include "render/live/object_solver.h"

namespace kappamu::render {

namespace {

/// Of the environment's light in the first answer.
constexpr double preview_rays = 0.05 * environment_rays;

std::optional<EnvironmentLight> environment_of(const std::vector<Light>& lights) {
  for (const Light& light : lights) {
    if (const auto* environment = std::get_if<EnvironmentLight>(&light)) return *environment;
  }
  return std::nullopt;
}

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

bool same(const std::optional<EnvironmentLight>& a, const std::optional<EnvironmentLight>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->image == b->image && (a->radiance == b->radiance).all() && a->turn_deg == b->turn_deg;
}

}  // namespace

LiveScene::LiveScene(const Scene& scene, const LiveOptions& options,
                     std::vector<std::string>& warnings, const ShapesKnown& shapes_known)
    : world_(scene, warnings, shapes_known),
      shapes_(scene),
      options_(options),
      tolerance_(options.tolerance.value_or(scene.model.tolerance)),
      chosen_(options.model),
      diffuse_(world_.objects().size()),
      albedo_(world_.objects().size()),
      furry_(std::any_of(scene.objects.begin(), scene.objects.end(),
                         [](const SceneObject& object) { return object.fur.has_value(); })) {
  const bool glows =
      std::any_of(world_.objects().begin(), world_.objects().end(),
                  [](const WorldObject& object) { return object.emission.maxCoeff() > 0.0; });
  if (glows || !world_.inner_lights().empty()) {
    throw InputError(scene.file.string() +
                     ": the window shows no light that begins inside objects; move the light, or "
                     "render a picture");
  }
}

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
    if (other) albedo_[object].reset();
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
  std::erase_if(solvers_, [&](const auto& one) {
    const bool answers = homogeneous || forward::object_model(one.first).can.heterogeneous;
    return refracts_otherwise || !answers;
  });
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
  for (const std::size_t object : others) albedo_[object].reset();
  features_.clear();
  std::erase_if(records_, [](const auto& record) { return record.first.second > 0; });
  for (auto& [step, record] : records_) record.error.reset();
  if (shapes_.any_moves()) return refused;
  refused_.clear();
  impossible_.clear();
  environment_rays_ = 0.0;
  return refused;
}

void LiveScene::light_environment(double rays, Progress& progress) {
  const std::optional<EnvironmentLight> light = environment_of(lights_);
  const bool as_before = same(light, environment_light_);
  if (as_before && (environment_rays_ >= rays || !environment_)) return;
  if (!as_before) {
    environment_ = make_environment(lights_);
    environment_light_ = light;
    environment_rays_ = 0.0;
  }
  std::vector<std::array<std::vector<double>, 3>> diffuse(solved().objects().size());
  for (std::size_t i = 0; environment_ && i < diffuse.size(); ++i) {
    IncidentLight incident =
        incident_light(solved(), i, {}, &*environment_, options_.seed, progress, rays);
    for (std::size_t c = 0; c < 3; ++c) diffuse[i][c] = std::move(incident.channels[c].diffuse);
  }
  diffuse_ = std::move(diffuse);
  environment_rays_ = rays;
}

LiveAnswer LiveScene::solve(const Step& step, Progress& progress) {
  const auto& [model, level] = step;
  const Solvers& solvers = solvers_.at(model);
  LiveAnswer answer;
  answer.model = model;
  answer.level = level;
  const Stopwatch light_watch;
  const LightSources sources = make_light_sources(lights_);
  std::vector<forward::LightOfChannels> incident;
  const World& world = solved();
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    std::vector<BeamPlace> places = level == 0 ? solvers[i]->places() : std::vector<BeamPlace>();
    if (places.empty() && shapes_.moves(i)) places = middles_of(world.objects()[i]);
    incident.push_back(
        places.empty()
            ? incident_light(world, i, sources, nullptr, options_.seed, progress).channels
            : beams_at(world, i, sources, places));
    for (std::size_t c = 0; c < 3; ++c) incident[i][c].diffuse = diffuse_[i][c];
  }
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
    answer.exitance.push_back({std::move(solved.exitance), diffuse_[i]});
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
    if (!albedo_[i]) {
      albedo_[i] = std::make_shared<const std::vector<Colour>>(albedo_below(object));
    }
    answer.surface.push_back(
        {object.boundary, object.roughness, albedo_[i], arriving_on(world, i, sources)});
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
  lights_ = question.lights;
  const Stopwatch shape_watch;
  mode_ = "static";
  asked_shape_ = question.shape;
  if (!solved_ && shapes_.differ_from(question.shape)) part_worlds(progress);
  std::string refused = take_model(question.model, progress);
  const std::string shape_refused = take_shapes(question.shape);
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
  return picture_.next(solved(), lights_, environment_ ? &*environment_ : nullptr, last_->exitance,
                       view, options_.seed, progress);
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
  const bool preview = environment_ && environment_rays_ < environment_rays;
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
