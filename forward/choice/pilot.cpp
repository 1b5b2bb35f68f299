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

/// Probability beyond which a model counts as within the tolerance, and below which it is given up;
/// `borne_out`: of a model that its law has taken already; `sure`: by the law, without a pilot.
constexpr double accepted = 0.9, given_up = 0.1, borne_out = 0.85, sure = 0.99;
/// Standard deviation of the squared error over the squared tolerance, that the first walk is for.
constexpr double first_deviation = 0.3;
/// Share of what the choice would cost otherwise that a pilot may, and of its own cost that the
/// pilot of a model may that its law has taken already.
constexpr double worth = 0.2, worth_of_taken = 1.2;
/// The taken model's seconds over those of a trial, below which a cheaper model is not tried.
constexpr double worthwhile = 3.0;
constexpr double fewest_pilot_photons = 2e3;

double normal_below(double deviations) {
  return 0.5 * std::erfc(-deviations / std::numbers::sqrt2);
}

struct Question {
  std::size_t candidate = 0;
  double photons = 0.0, most_photons = 0.0;  ///< of the first walk, and of the last
  bool taken = false;                        ///< by its law already
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

/// Of one photon in every channel, and what the first walk needs.
struct WalkNeeds {
  double photons = fewest_pilot_photons, seconds = 0.0;
};

WalkNeeds needs(std::span<const ObjectFeatures> channels, std::size_t patches,
                const ObjectOptions& asked, const MachineCosts& costs) {
  WalkNeeds result;
  result.seconds = per_photon(channels, costs);
  for (const ObjectFeatures& features : channels) {
    const double noise = error_by(measured(random_walks)->error, features);
    result.photons =
        std::max(result.photons, noise * noise * std::sqrt(2.0 * static_cast<double>(patches)) /
                                     (first_deviation * asked.tolerance * asked.tolerance));
  }
  return result;
}

/// By its law, in all channels.
double probability_of(const std::string& model, std::span<const ObjectFeatures> channels,
                      double tolerance) {
  double least = 1.0;
  for (const ObjectFeatures& features : channels) {
    const ErrorLaw& law = measured(model)->error;
    least = std::min(least, probability_below({error_by(law, features), law.spread}, tolerance));
  }
  return least;
}

/// Diffusion by other numerics errs alike.
bool same_physics(std::string_view a, std::string_view b) {
  const auto diffusion = [](std::string_view name) {
    return name == "embedded" || name == "grid" || name == "boundary_integral";
  };
  return a == b || (diffusion(a) && diffusion(b));
}

/// The model whose trial is expected to save most, if any is: a cheaper one than the one taken, or
/// that one itself where its law leaves a doubt.
std::optional<Question> question(std::span<const ObjectFeatures> channels, const WalkNeeds& walk,
                                 const ObjectOptions& asked, const Choice& choice,
                                 const std::vector<std::string>& tried) {
  const std::vector<ModelCandidate>& all = choice.candidates;
  const ModelCandidate& taken = all.front();
  const auto open = [&](const ModelCandidate& c) {
    return c.error && c.model != random_walks &&
           std::none_of(tried.begin(), tried.end(),
                        [&](const std::string& other) { return same_physics(c.model, other); });
  };
  if (!taken.seconds) return {};
  std::optional<Question> found;
  double least = *taken.seconds;
  for (std::size_t i = 1; i < all.size() && walk.photons * walk.seconds <= worth * *taken.seconds;
       ++i) {
    if (!open(all[i])) continue;
    const double probability = probability_of(all[i].model, channels, asked.tolerance);
    if (probability < given_up) continue;
    const double trial = *all[i].seconds + walk.photons * walk.seconds;
    const double expected = trial + (1.0 - probability) * *taken.seconds;
    if (expected >= least || worthwhile * trial > *taken.seconds) continue;
    least = expected;
    found = {i, walk.photons, worth * *taken.seconds / walk.seconds, false};
  }
  const bool second = all.size() > 1 && all[1].error && *all[1].error <= asked.tolerance;
  if (found || !choice.within_tolerance || !second || !open(taken)) return found;
  if (probability_of(taken.model, channels, asked.tolerance) >= sure) return {};
  const double affordable = worth_of_taken * *taken.seconds / walk.seconds;
  if (affordable < fewest_pilot_photons) return {};
  return Question{0, std::min(2.0 * walk.photons, affordable),
                  std::max(affordable, worth * *all[1].seconds / walk.seconds), true};
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
  double difference = 0.0, variance = 0.0, cross = 0.0, signal = 0.0, area = 0.0;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const double noise = error[p] * error[p];
    const double square = std::pow(walked[p] - mean[p], 2);
    difference += patches.area[p] * (square - noise);
    variance += 2.0 * std::pow(patches.area[p] * noise, 2);
    cross += 4.0 * std::pow(patches.area[p], 2) * noise;
    area += patches.area[p];
    signal += patches.area[p] * mean[p] * mean[p];
  }
  if (signal == 0.0) return {};
  // Noise times difference, as if that were the same everywhere: of a patch alone it is not known.
  variance += cross * std::max(0.0, difference) / area;
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

namespace {

/// Random walks of all channels, lengthened where a question asks for more photons.
class Walks {
 public:
  Walks(std::span<const ObjectProblem> problems, const ObjectOptions& asked, Progress& progress)
      : problems_(problems), options_(asked), progress_(progress) {
    options_.photons = 0;
  }

  std::uint64_t photons() const { return options_.photons; }
  const std::vector<ObjectResult>& of(double photons) {
    if (static_cast<double>(options_.photons) < photons) {
      options_.photons = static_cast<std::uint64_t>(std::ceil(photons));
      results_.clear();
      for (const ObjectProblem& problem : problems_) {
        results_.push_back(make_object_model(random_walks)->solve(problem, options_, progress_));
      }
    }
    return results_;
  }

 private:
  std::span<const ObjectProblem> problems_;
  ObjectOptions options_;
  Progress& progress_;
  std::vector<ObjectResult> results_;
};

/// The pilot's belief after these walks, of the channel and light least likely to be within.
void believe(std::span<const ObjectProblem> problems, std::span<const ObjectFeatures> channels,
             const Patches& patches, const std::vector<ObjectResult>& walks, double tolerance,
             Pilot& pilot) {
  const ErrorLaw& law = measured(pilot.model)->error;
  pilot.probability = 1.0;
  for (std::size_t c = 0; c < problems.size(); ++c) {
    for (std::size_t l = 0; l < problems[c].lights.size(); ++l) {
      ErrorBelief belief = compared(patches, problems[c].surface, pilot.results[c], walks[c], l);
      belief.law = error_by(law, channels[c]);
      belief.spread = law.spread;
      const double probability = probability_below(belief, tolerance);
      if (probability > pilot.probability) continue;
      pilot.probability = probability;
      pilot.belief = belief;
    }
  }
}

/// Puts what the pilot found into the choice.
void conclude(const Pilot& pilot, std::size_t place, double tolerance, Choice& choice) {
  const auto found = choice.candidates.begin() + static_cast<std::ptrdiff_t>(place);
  found->reason = "a pilot of " + std::to_string(pilot.photons) + " photons measured an error of " +
                  number(100.0 * pilot.error(), "%.2g") +
                  " %, within the tolerance with probability " + number(pilot.probability, "%.2f");
  if (pilot.within) {
    found->error = std::min(*found->error, tolerance);
    if (place == 0) return;
    choice.candidates.front().reason = "takes longer: " + choice.candidates.front().reason;
    std::rotate(choice.candidates.begin(), found, found + 1);
    choice.within_tolerance = true;
    return;
  }
  for (ModelCandidate& c : choice.candidates) {
    if (c.error && same_physics(c.model, pilot.model))
      c.error = std::max({*c.error, pilot.error(), 1.01 * tolerance});
  }
  rank(choice, tolerance);
  if (place > 0) return;
  choice.candidates.front().reason =
      "a pilot gave " + pilot.model + " up; " + choice.candidates.front().reason;
}

}  // namespace

std::optional<Pilot> run_pilot(std::span<const ObjectProblem> problems,
                               std::span<const ObjectFeatures> channels, const ObjectOptions& asked,
                               const MachineCosts& costs, Choice& choice, Progress& progress) {
  const ObjectProblem& object = problems.front();
  const Patches patches = make_patches(object.surface, bounding_box(object.mesh), patches_across);
  const WalkNeeds walk = needs(channels, patches.size(), asked, costs);
  Walks walks(problems, asked, progress);
  std::vector<std::string> tried;
  std::optional<Pilot> last;
  while (const auto asks = question(channels, walk, asked, choice, tried)) {
    ModelCandidate& candidate = choice.candidates[asks->candidate];
    Pilot pilot;
    pilot.model = candidate.model;
    tried.push_back(pilot.model);
    progress.update("choice of a model", 0.0, "a pilot for " + pilot.model);
    try {
      pilot.results =
          make_object_model(pilot.model)
              ->solve_channels(problems, options_for(pilot.model, channels, asked), progress);
    } catch (const InputError& refusal) {
      candidate = {pilot.model, {}, {}, std::string("refused: ") + refusal.what()};
      rank(choice, asked.tolerance);
      continue;
    }
    const double enough = asks->taken ? borne_out : accepted;
    for (double photons = asks->photons;; photons *= 4.0) {
      believe(problems, channels, patches, walks.of(photons), asked.tolerance, pilot);
      pilot.photons = walks.photons();
      if (pilot.probability >= enough || pilot.probability <= given_up) break;
      if (4.0 * photons > asks->most_photons) break;
    }
    pilot.within = pilot.probability >= enough;
    conclude(pilot, asks->candidate, asked.tolerance, choice);
    last = std::move(pilot);
    if (last->within) break;
  }
  return last;
}

}  // namespace kappamu::forward
