#include "render/live/live_scene.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/processor_time.h"
#include "forward/model_error.h"
#include "forward/registry.h"
#include "render/light/beam_places.h"
#include "render/light/incident_light.h"
#include "render/live/object_solver.h"

namespace kappamu::render {

namespace {

/// An answer of this time keeps up with a hand on a light [ms].
constexpr double moving_ms = 100.0;
/// Of the environment's light in the first answer.
constexpr double preview_rays = 0.05 * environment_rays;
/// Of [M] 5.5: nothing is kept.
constexpr const char* anew_mode = "on the fly";
/// Another model is worth its time where it errs by less than this share.
constexpr double worthwhile = 0.7;

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
                     std::vector<std::string>& warnings)
    : world_(scene, warnings),
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

std::vector<std::string> LiveScene::candidates() const {
  if (chosen_) return {*chosen_};
  std::vector<std::string> models = live_models(solved());
  std::erase_if(models, [&](const std::string& model) { return refused_.contains(model); });
  return models;
}

LiveScene::Solvers LiveScene::make_solvers(const std::string& model, Progress& progress) const {
  if (!forward::object_model(model).can.heterogeneous && !all_homogeneous(solved())) {
    throw InputError("model " + model +
                     " answers for homogeneous objects alone; use the model embedded");
  }
  forward::ObjectOptions options;
  options.device = options_.device;
  options.seed = options_.seed;
  options.tolerance = tolerance_;
  Solvers solvers;
  for (const WorldObject& object : solved().objects()) {
    solvers.push_back(std::make_unique<ObjectSolver>(
        object, model, options_.model == model ? options_.parameters : OptionValues(), options,
        progress));
  }
  return solvers;
}

const LiveScene::Solvers* LiveScene::solvers_of(const std::string& model, Progress& progress) {
  try {
    const auto made = solvers_.find(model);
    if (made == solvers_.end()) return &(solvers_[model] = make_solvers(model, progress));
    for (const auto& solver : made->second) {
      if (!solver->is_behind()) continue;
      const bool followed = solver->follow(asked_shape_, progress);
      if (mode_ != anew_mode) mode_ = followed ? "incremental" : anew_mode;
    }
    return &made->second;
  } catch (const InputError& refusal) {
    refused_[model] = refusal.what();
    solvers_.erase(model);
    return nullptr;
  }
}

bool LiveScene::keep(const Solvers& solvers) {
  return std::all_of(solvers.begin(), solvers.end(),
                     [](const auto& solver) { return solver->keeps(); });
}

/// Of the first model that keeps what it can from light to light; else of the first that answers.
LiveScene::Step LiveScene::first_step(Progress& progress) {
  std::optional<Step> anew;
  const std::vector<std::string> models = candidates();
  for (const std::string& model : models) {
    const Solvers* solvers = solvers_of(model, progress);
    if (solvers == nullptr) continue;
    if (keep(*solvers)) return {model, 0};
    if (!anew) anew = Step{model, 0};
  }
  if (anew) return *anew;
  throw InputError(models.empty() ? refused_.begin()->second : refused_.at(models.front()));
}

LiveScene::Step LiveScene::moving_step(Progress& progress) {
  const std::vector<std::string> models = candidates();
  std::optional<Step> best;
  const auto rank = [&](const Step& step) {
    const Record& record = records_.at(step);
    const double error =
        std::hypot(record.error.value_or(1.0), model_error(step.first).value_or(1.0));
    const bool keeps_up = record.milliseconds <= moving_ms;
    return std::tuple(!keeps_up, keeps_up ? error : record.milliseconds);
  };
  for (const auto& [step, record] : records_) {
    if (!solvers_.contains(step.first)) continue;
    if (std::find(models.begin(), models.end(), step.first) == models.end()) continue;
    if (!best || rank(step) < rank(*best)) best = step;
  }
  if (best && solvers_of(best->first, progress) != nullptr) return *best;
  return first_step(progress);
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

/// While shapes move, the coarsest of a model that can follow them.
LiveScene::Step LiveScene::answering_step(Progress& progress, std::string& refused) {
  const auto step = [&] {
    return shapes_.any_moves() ? first_step(progress) : moving_step(progress);
  };
  try {
    return step();
  } catch (const InputError& refusal) {
    // The model that a person chose may not answer for a changed medium or shape.
    if (!last_ || !chosen_) throw;
    refused = refusal.what();
    chosen_.reset();
    return step();
  }
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

std::optional<double> LiveScene::model_error(const std::string& model) const {
  std::optional<double> worst;
  for (const auto& channels : features_) {
    for (const forward::ObjectFeatures& features : channels) {
      const auto error = forward::expected_error(forward::object_model(model), features);
      if (error) worst = std::max(worst.value_or(0.0), *error);
    }
  }
  return worst;
}

/// Another model that errs by less against transport where the last one errs by too much.
std::optional<LiveScene::Step> LiveScene::better_model(Progress& progress) {
  const std::optional<double> error = model_error(last_->model);
  if (chosen_ || !error || *error <= tolerance_) return std::nullopt;
  std::optional<Step> anew;
  for (const std::string& model : candidates()) {
    const std::optional<double> of_model = model_error(model);
    if (!of_model || *of_model > worthwhile * *error) continue;
    const Solvers* solvers = solvers_of(model, progress);
    if (solvers == nullptr) continue;
    const Step step{model, keep(*solvers) ? 0 : 1};
    if (impossible_.contains(step)) continue;
    if (step.second == 0) return step;
    if (!anew) anew = step;
  }
  return anew;
}

std::optional<LiveScene::Step> LiveScene::next_step(Progress& progress) {
  if (const auto other = better_model(progress)) return other;
  const bool exact = last_->error_estimate && *last_->error_estimate <= tolerance_;
  int levels = std::numeric_limits<int>::max();
  for (const auto& solver : solvers_.at(last_->model)) levels = std::min(levels, solver->levels());
  const Step finer{last_->model, last_->level + 1};
  if (exact || finer.second >= levels || impossible_.contains(finer)) return std::nullopt;
  return finer;
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
