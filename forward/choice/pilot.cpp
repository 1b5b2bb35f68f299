#include "forward/choice/pilot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/error.h"
#include "forward/choice/patches.h"
#include "forward/object_models.h"

namespace kappamu::forward {

namespace {

/// Probability beyond which a model counts as within the tolerance, and below which it is given up.
constexpr double accepted = 0.9, given_up = 0.1;
/// Standard deviation of the squared error over the squared tolerance, that the first walk is for.
constexpr double first_deviation = 0.3;
/// Share of what the choice would cost otherwise that a pilot may.
constexpr double worth = 0.2;
constexpr double fewest_pilot_photons = 2e3;

double normal_below(double deviations) {
  return 0.5 * std::erfc(-deviations / std::numbers::sqrt2);
}

struct Question {
  std::size_t candidate = 0;
  double photons = 0.0, walk_seconds = 0.0;  ///< of one photon in every channel
};

const MeasuredModel* measured(std::string_view name) {
  for (const MeasuredModel& model : measured_models()) {
    if (model.name == name) return &model;
  }
  return nullptr;
}

double per_photon(std::span<const ObjectFeatures> channels, const MachineCosts& costs) {
  const MeasuredModel& walks = *measured(random_walks);
  double seconds = 0.0;
  for (const ObjectFeatures& features : channels)
    seconds += seconds_by(walks.seconds, features, 1.0);
  const auto here = costs.find(random_walks);
  return here == costs.end() ? seconds : seconds * here->second;
}

/// The model whose trial is expected to save most, if any is.
std::optional<Question> question(std::span<const ObjectFeatures> channels, std::size_t patches,
                                 const ObjectOptions& asked, const MachineCosts& costs,
                                 const Choice& choice) {
  const ModelCandidate& taken = choice.candidates.front();
  if (taken.model != random_walks || !taken.seconds) return {};
  Question best;
  best.walk_seconds = per_photon(channels, costs);
  for (const ObjectFeatures& features : channels) {
    const double noise = error_by(measured(random_walks)->error, features);
    best.photons =
        std::max(best.photons, noise * noise * std::sqrt(2.0 * static_cast<double>(patches)) /
                                   (first_deviation * asked.tolerance * asked.tolerance));
  }
  best.photons = std::ceil(std::max(best.photons, fewest_pilot_photons));
  if (best.photons * best.walk_seconds > worth * *taken.seconds) return {};
  std::optional<Question> found;
  double least = *taken.seconds;
  for (std::size_t i = 1; i < choice.candidates.size(); ++i) {
    const ModelCandidate& c = choice.candidates[i];
    if (!c.error || c.model == random_walks) continue;
    double probability = 1.0;
    for (const ObjectFeatures& features : channels) {
      const ErrorLaw& law = measured(c.model)->error;
      probability = std::min(
          probability, probability_below({error_by(law, features), law.spread}, asked.tolerance));
    }
    if (probability < given_up) continue;
    const double expected =
        *c.seconds + best.photons * best.walk_seconds + (1.0 - probability) * *taken.seconds;
    if (expected >= least) continue;
    least = expected;
    best.candidate = i;
    found = best;
  }
  return found;
}

/// Squared difference of an answer from a walk over patches, the walk's noise taken off, over the
/// answer's square; with its standard deviation.
ErrorBelief compared(const Patches& patches, const Surface& surface, const ObjectResult& answer,
                     const ObjectResult& walk, std::size_t light) {
  const std::size_t samples = surface.size();
  const auto part = [&](const std::vector<double>& values) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(light * samples);
    return std::vector<double>(first, first + static_cast<std::ptrdiff_t>(samples));
  };
  const std::vector<double> mean = patches.mean(part(answer.exitance), surface);
  const std::vector<double> walked = patches.mean(part(walk.exitance), surface);
  const std::vector<double> error =
      patches.error_of_mean(part(walk.exitance), part(walk.standard_error), surface);
  double difference = 0.0, variance = 0.0, signal = 0.0;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const double noise = error[p] * error[p];
    const double square = std::pow(walked[p] - mean[p], 2);
    difference += patches.area[p] * (square - noise);
    variance += std::pow(patches.area[p], 2) *
                (2.0 * noise * noise + 4.0 * std::max(0.0, square - noise) * noise);
    signal += patches.area[p] * mean[p] * mean[p];
  }
  if (signal == 0.0) return {};
  return {0.0, 0.0, difference / signal, std::sqrt(variance) / signal};
}

std::string number(double value, const char* format) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

}  // namespace

double probability_below(const ErrorBelief& belief, double bound) {
  if (belief.square_deviation <= 0.0) {
    return normal_below(std::log(bound / belief.law) / belief.spread);
  }
  // The trapezoidal rule over deviations of the logarithm from the law.
  constexpr double farthest = 5.0, step = 0.01;
  double below = 0.0, all = 0.0;
  const double within = std::log(bound / belief.law) / belief.spread;
  for (double x = -farthest; x <= farthest; x += step) {
    const double error = belief.law * std::exp(belief.spread * x);
    const double off = (error * error - belief.square) / belief.square_deviation;
    const double weight = std::exp(-0.5 * (x * x + off * off));
    all += weight;
    below += weight * std::clamp((within - x) / step + 0.5, 0.0, 1.0);
  }
  return all > 0.0 ? below / all : 0.0;
}

std::optional<Pilot> run_pilot(std::span<const ObjectProblem> problems,
                               std::span<const ObjectFeatures> channels, const ObjectOptions& asked,
                               const MachineCosts& costs, Choice& choice, Progress& progress) {
  const ObjectProblem& object = problems.front();
  const Patches patches = make_patches(object.surface, bounding_box(object.mesh), patches_across);
  const auto asks = question(channels, patches.size(), asked, costs, choice);
  if (!asks) return {};
  ModelCandidate& candidate = choice.candidates[asks->candidate];
  Pilot pilot;
  pilot.model = candidate.model;
  progress.update("choice of a model", 0.0, "a pilot for " + pilot.model);
  try {
    pilot.results =
        make_object_model(pilot.model)
            ->solve_channels(problems, options_for(pilot.model, channels, asked), progress);
  } catch (const InputError& refusal) {
    candidate.reason = std::string("refused: ") + refusal.what();
    return {};
  }
  const ErrorLaw& law = measured(pilot.model)->error;
  const double most = worth * *choice.candidates.front().seconds / asks->walk_seconds;
  ObjectOptions options = asked;
  for (double photons = asks->photons;; photons *= 4.0) {
    pilot.photons = options.photons = static_cast<std::uint64_t>(photons);
    pilot.probability = 1.0;
    for (std::size_t c = 0; c < problems.size(); ++c) {
      const ObjectResult walk =
          make_object_model(random_walks)->solve(problems[c], options, progress);
      for (std::size_t l = 0; l < problems[c].lights.size(); ++l) {
        ErrorBelief belief = compared(patches, object.surface, pilot.results[c], walk, l);
        belief.law = error_by(law, channels[c]);
        belief.spread = law.spread;
        const double probability = probability_below(belief, asked.tolerance);
        if (probability > pilot.probability) continue;
        pilot.probability = probability;
        pilot.belief = belief;
      }
    }
    const bool decided = pilot.probability >= accepted || pilot.probability <= given_up;
    if (decided || 4.0 * photons > most) break;
  }
  pilot.within = pilot.probability >= accepted;
  candidate.reason = "a pilot of " + std::to_string(pilot.photons) +
                     " photons measured an error of " + number(100.0 * pilot.error(), "%.2g") +
                     " %, within the tolerance with probability " +
                     number(pilot.probability, "%.2f");
  if (pilot.within) {
    candidate.error = std::min(*candidate.error, asked.tolerance);
    const auto place = choice.candidates.begin() + static_cast<std::ptrdiff_t>(asks->candidate);
    choice.candidates.front().reason = "takes longer: " + choice.candidates.front().reason;
    std::rotate(choice.candidates.begin(), place, place + 1);
    choice.within_tolerance = true;
  }
  return pilot;
}

}  // namespace kappamu::forward
