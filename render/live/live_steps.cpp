// Which model answers a live scene's question, and at which of its levels.
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/error.h"
#include "forward/model_error.h"
#include "forward/registry.h"
#include "render/live/live_scene.h"
#include "render/live/object_solver.h"

namespace kappamu::render {

namespace {

/// An answer of this time keeps up with a hand on a light [ms].
constexpr double moving_ms = 100.0;
/// Another model is worth its time where it errs by less than this share.
constexpr double worthwhile = 0.7;

}  // namespace

std::vector<std::string> LiveScene::candidates() const {
  if (chosen_) return {*chosen_};
  std::vector<std::string> models = live_models(solved());
  std::erase_if(models, [&](const std::string& model) { return refused_.contains(model); });
  return models;
}

/// Throws InputError where the model does not answer for the objects' media and light.
void LiveScene::expect_able(const std::string& model) const {
  const forward::Abilities& can = forward::object_model(model).can;
  if (!can.heterogeneous && !all_homogeneous(solved())) {
    throw InputError("model " + model +
                     " answers for homogeneous objects alone; use the model embedded");
  }
  if (!can.inner_light && solved().lit_inside()) {
    throw InputError("model " + model +
                     " takes light from outside alone; move the light out of the object, or use "
                     "the model embedded");
  }
}

LiveScene::Solvers LiveScene::make_solvers(const std::string& model, Progress& progress) const {
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
    expect_able(model);
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

}  // namespace kappamu::render
