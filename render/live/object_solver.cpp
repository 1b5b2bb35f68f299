#include "render/live/object_solver.h"

#include <algorithm>
#include <limits>

#include "forward/registry.h"

namespace kappamu::render {

using forward::ChannelProblems;
using forward::ExitanceOfChannels;
using forward::LightOfChannels;

ObjectSolver::ObjectSolver(const WorldObject& lit, const std::string& model,
                           const OptionValues& parameters, const forward::ObjectOptions& options,
                           Progress& progress)
    : lit_(lit),
      object_{lit.mesh, lit.surface, *lit.rays, lit.media.channels, lit.boundary.eta, lit.drawn()},
      model_(forward::make_object_model(model, forward::ModelError::left_out, parameters)),
      options_(options),
      kept_(model_->keep(object_, options, progress)) {
  place_beams();
}

void ObjectSolver::place_beams() {
  if (!kept_ || kept_->beam_spacing_mm() <= 0.0) return;
  places_ = beam_places(lit_, {kept_->beam_spacing_mm(), kept_->beam_spacing_mm()});
}

bool ObjectSolver::follow(const ShapeQuestion& shape, Progress& progress) {
  const double most_ms = shape.moving ? shape.most_ms : std::numeric_limits<double>::infinity();
  const bool follows = shape.by == FollowBy::update && kept_ && kept_->follow(most_ms);
  if (!follows) kept_ = model_->keep(object_, options_, progress);
  place_beams();
  behind_ = kept_ && !kept_->caught_up();
  return follows;
}

ObjectSolver::Answer ObjectSolver::solve(const LightOfChannels& light, int level,
                                         Progress& progress) {
  if (!kept_) return solve_anew(light, level, progress);
  return {kept_->solve(light, level, progress), std::nullopt};
}

ObjectSolver::Answer ObjectSolver::solve_anew(const LightOfChannels& light, int level,
                                              Progress& progress) {
  constexpr double coarse_tolerance = 0.3;
  forward::ObjectOptions options = options_;
  if (level + 1 < anew_levels) options.tolerance = std::max(coarse_tolerance, options.tolerance);
  const ChannelProblems problems(object_, light);
  std::vector<forward::ObjectResult> results =
      model_->solve_channels(problems.all(), options, progress);
  Answer answer;
  answer.error = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    answer.exitance[c] = std::move(results[c].exitance);
    answer.error = std::max(*answer.error, results[c].error_estimate[0]);
    answer.iterations = std::max(answer.iterations, results[c].iterations);
    answer.elements = std::max(answer.elements, results[c].elements);
    answer.converged = answer.converged && results[c].converged;
  }
  return answer;
}

std::optional<double> ObjectSolver::measured_error(const LightOfChannels& light, int level,
                                                   const ExitanceOfChannels& fine,
                                                   const ExitanceOfChannels& coarse) const {
  return kept_ ? kept_->measured_error(light, level, fine, coarse) : std::nullopt;
}

std::vector<forward::ObjectFeatures> ObjectSolver::features(const LightOfChannels& light) const {
  const ChannelProblems problems(object_, light);
  std::vector<forward::ObjectFeatures> features;
  for (std::size_t c = 0; c < 3; ++c) features.push_back(forward::features_of(problems[c], 0));
  return features;
}

}  // namespace kappamu::render
