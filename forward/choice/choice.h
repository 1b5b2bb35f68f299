// The program that chooses: the cheapest model of those that were measured to err no more than the
// tolerance on objects like this one.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "forward/registry.h"

namespace kappamu::forward {

/// What `auto` is asked: the tolerance is of physics and numerics together.
struct ChoiceOptions : ObjectOptions {
  std::uint64_t photons = 1'000'000;  ///< per light, the most that random walks may take
};

/// What is done where a model errs more than is asked.
enum class Remedy { none, walks };  ///< walks: forward/choice/correction.h

struct Choice {
  std::vector<ModelCandidate> candidates;  ///< the one to take first, then by cost, then the others
  bool within_tolerance = false;    ///< the first is expected to err no more than the tolerance
  double seconds_per_photon = 0.0;  ///< of all channels' walks
};

/// All models that may be chosen.
std::vector<const ModelDescription*> choosable_models();

/// `channels` are the same object in the media of its colour channels, which one model answers. A
/// model that is beyond the tolerance counts with its remedy.
Choice choose_model(std::span<const ModelDescription* const> models,
                    std::span<const ObjectFeatures> channels, const ChoiceOptions& asked,
                    Remedy remedy);

/// Orders the candidates by what is now known of them: within the tolerance by cost, beyond it by
/// error, then those of unknown error.
void rank(Choice& choice, double tolerance);

/// What to ask of a model for the error that choose_model() expects: half the tolerance of its
/// numerics; of random walks the tolerance, and the photons that bring their noise below it.
ChoiceOptions options_for(const ModelDescription& model, std::span<const ObjectFeatures> channels,
                          const ChoiceOptions& asked);

/// The model that answers so; random walks take the photons asked.
std::unique_ptr<ObjectModel> make_chosen(const ModelDescription& model, const ChoiceOptions& asked);

}  // namespace kappamu::forward
