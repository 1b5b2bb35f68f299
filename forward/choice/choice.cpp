#include "forward/choice/choice.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "core/shown_text.h"
#include "forward/choice/correction.h"
#include "forward/choice/error_belief.h"
#include "forward/patches.h"

namespace kappamu::forward {

namespace {

/// Of the tolerance: what a model's numerics are asked for.
constexpr double numerics_share = 0.5;
/// Probability by its law that an error is below what is expected at most; and those that walks may
/// be planned to correct it with.
constexpr double expected_at_most = 0.95;
constexpr std::array correctable{expected_at_most, 0.8, 0.5, 0.2};
/// Of the tolerance: the noise that is planned, of corrected answers, whose walks are lengthened on
/// demand, and of answers by walks alone, two standard deviations of their law below it.
constexpr double noise_share = 0.9, lone_noise_share = 0.7;
constexpr double fewest_photons = 2e4, fewest_walk = 2e3;
/// Of correcting walks: seconds of start and comparison per triangle, and how much longer than
/// planned they become in the mean.
constexpr double seconds_per_triangle = 2.5e-6, lengthened = 1.5;
/// Thinner than the thinnest measured by more than this factor, errors are not known.
constexpr double beyond = 1.25;

std::string percent(double value) {
  return shown_number(100.0 * value, "%.2g %%");
}

std::string number(double value) {
  return shown_number(value, value < 100.0 ? "%.2g" : "%.0f");
}

/// Noise of the patches after one photon.
double noise_of_one(const ModelDescription& model, const ObjectFeatures& features) {
  return error_by(model.measured->error, features) *
         std::sqrt(static_cast<double>(features.patches));
}

/// Photons of the channel that needs most, or those allowed.
double photons_for(const ModelDescription& model, std::span<const ObjectFeatures> channels,
                   const ChoiceOptions& asked) {
  double most = fewest_photons;
  for (const ObjectFeatures& features : channels) {
    const double noise = noise_of_one(model, features);
    most = std::max(most, std::pow(noise / (lone_noise_share * asked.tolerance), 2.0));
  }
  return std::min(most, static_cast<double>(asked.photons));
}

/// Why errors of the model on this object are not known; empty where they are.
std::string unmeasured(const ModelDescription& model, const ObjectFeatures& features,
                       const ChoiceOptions& asked) {
  if (!model.can.heterogeneous && features.contrast > 1.0)
    return "the medium is not the same everywhere";
  if (!model.can.any_shape && !features.block) return "the object is no box of whole voxels";
  if (!model.can.reentry && asked.follow_reentry)
    return "does not follow light that meets the object again";
  if (model.measured == nullptr) return "its error and cost were not measured";
  if (model.can.transport) return "";
  const MeasuredRange range = measured_range();
  if (features.thickness * beyond < range.thinnest) {
    return "not measured on objects as thin as " + number(features.thickness) +
           " mean free paths (2V/S)";
  }
  if (1.0 - features.albedo > beyond * (1.0 - range.lowest_albedo)) {
    return "not measured at an albedo as low as " + number(features.albedo);
  }
  if (features.contrast > beyond * range.highest_contrast) {
    return "not measured in media of contrast " + number(features.contrast);
  }
  return "";
}

/// What the worst channel's error does not exceed with this probability.
double error_of(const ModelDescription& model, std::span<const ObjectFeatures> channels,
                const ChoiceOptions& asked, double probability) {
  double worst = 0.0;
  for (const ObjectFeatures& features : channels) {
    if (model.can.transport) {
      const ErrorBelief law{
          noise_of_one(model, features) / std::sqrt(photons_for(model, channels, asked)),
          model.measured->error.spread};
      worst = std::max(worst, error_quantile(law, probability));
    } else {
      const ErrorBelief law{error_by(model.measured->error, features),
                            model.measured->error.spread};
      worst = std::max(
          worst, std::hypot(error_quantile(law, probability), numerics_share * asked.tolerance));
    }
  }
  return worst;
}

/// Of `montecarlo`: of one photon in every channel.
double seconds_of(const ModelDescription& model, std::span<const ObjectFeatures> channels,
                  const ChoiceOptions& asked) {
  double seconds = 0.0;
  for (const ObjectFeatures& features : channels) {
    seconds += seconds_by(model.measured->seconds, features, numerics_share * asked.tolerance);
  }
  const auto here = asked.costs.find(model.name);
  return here == asked.costs.end() ? seconds : seconds * here->second;
}

/// Photons that correct an answer of error `error` to `wanted`, in the channel that needs most.
double correcting_photons(double error, double wanted, std::span<const ObjectFeatures> channels) {
  const double noise = noise_that_leaves(error, wanted);
  double most = 0.0;
  for (const ObjectFeatures& features : channels) {
    most = std::max(most, std::pow(noise_of_one(transport_model(), features) / noise, 2.0));
  }
  return most;
}

ModelCandidate candidate(const ModelDescription& model, std::span<const ObjectFeatures> channels,
                         const ChoiceOptions& asked, Remedy remedy) {
  ModelCandidate result;
  result.model = model.name;
  for (const ObjectFeatures& features : channels) {
    result.reason = unmeasured(model, features, asked);
    // A volume's voxels may be many more than those of the boxes measured.
    if (result.reason.empty() && remedy == Remedy::walks && !model.can.any_shape &&
        features.contrast > 1.0)
      result.reason = "its seconds are not known where the medium is not the same everywhere";
    if (!result.reason.empty()) return result;
  }
  result.error = error_of(model, channels, asked, expected_at_most);
  result.seconds = seconds_of(model, channels, asked);
  const ModelDescription& walks = transport_model();
  const double per_photon = seconds_of(walks, channels, asked);
  const double walk_seconds = per_photon * photons_for(walks, channels, asked);
  if (model.can.transport) result.seconds = walk_seconds;
  if (remedy == Remedy::none || model.can.transport || *result.error <= asked.tolerance)
    return result;
  const double start =
      seconds_per_triangle * static_cast<double>(channels.front().triangles * channels.size());
  std::optional<double> least;
  for (const double probability : correctable) {
    const double error = error_of(model, channels, asked, probability);
    const double photons =
        std::max(fewest_walk, correcting_photons(error, noise_share * asked.tolerance, channels));
    if (photons > static_cast<double>(asked.photons)) continue;
    // Where they do not suffice, longer walks answer alone.
    const double seconds = *result.seconds + start + lengthened * photons * per_photon +
                           (1.0 - probability / expected_at_most) * walk_seconds;
    if (least && *least <= seconds) continue;
    least = seconds;
    result.photons = photons;
  }
  if (!least) return result;
  result.seconds = least;
  result.error = asked.tolerance;
  return result;
}

}  // namespace

std::vector<const ModelDescription*> choosable_models() {
  std::vector<const ModelDescription*> models;
  for (const ModelDescription& model : object_models()) {
    if (!model.can.chooses) models.push_back(&model);
  }
  return models;
}

Choice choose_model(std::span<const ModelDescription* const> models,
                    std::span<const ObjectFeatures> channels, const ChoiceOptions& asked,
                    Remedy remedy) {
  check(!channels.empty(), "choose_model: no channel");
  Choice choice;
  for (const ModelDescription* model : models) {
    choice.candidates.push_back(candidate(*model, channels, asked, remedy));
  }
  choice.seconds_per_photon = seconds_of(transport_model(), channels, asked);
  rank(choice, asked.tolerance);
  for (ModelCandidate& c : choice.candidates) {
    if (!c.error) continue;
    const bool first = &c == &choice.candidates.front();
    const std::string expected =
        (c.photons > 0.0 ? "corrected by " + number(c.photons) + " photons, " : std::string()) +
        "error at most " + percent(*c.error) + ", " + number(*c.seconds) + " s expected";
    if (first) {
      c.reason = (choice.within_tolerance ? "the cheapest within the tolerance: "
                                          : "none is within the tolerance, the nearest: ") +
                 expected;
    } else {
      c.reason =
          (*c.error <= asked.tolerance ? "takes longer: " : "beyond the tolerance: ") + expected;
    }
  }
  return choice;
}

void rank(Choice& choice, double tolerance) {
  const auto place = [&](const ModelCandidate& c) {
    return !c.error ? 2 : *c.error <= tolerance ? 0 : 1;
  };
  std::stable_sort(choice.candidates.begin(), choice.candidates.end(),
                   [&](const ModelCandidate& a, const ModelCandidate& b) {
                     if (place(a) != place(b) || place(a) == 2) return place(a) < place(b);
                     return place(a) == 0 ? *a.seconds < *b.seconds : *a.error < *b.error;
                   });
  choice.within_tolerance = place(choice.candidates.front()) == 0;
}

ChoiceOptions options_for(const ModelDescription& model, std::span<const ObjectFeatures> channels,
                          const ChoiceOptions& asked) {
  ChoiceOptions options = asked;
  if (model.can.transport) {
    options.photons = static_cast<std::uint64_t>(photons_for(model, channels, asked));
  } else {
    options.tolerance = numerics_share * asked.tolerance;
  }
  return options;
}

std::unique_ptr<ObjectModel> make_chosen(const ModelDescription& model,
                                         const ChoiceOptions& asked) {
  OptionValues parameters;
  if (model.can.transport) parameters["photons"] = static_cast<double>(asked.photons);
  return make_object_model(model.name, ModelError::stated, parameters);
}

}  // namespace kappamu::forward
