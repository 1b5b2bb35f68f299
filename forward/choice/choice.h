// The program that chooses: the cheapest model of those that were measured to err no more than the
// tolerance on objects like this one.
#pragma once

#include <span>
#include <vector>

#include "forward/choice/machine_costs.h"
#include "forward/choice/model_table.h"

namespace kappamu::forward {

/// The model that is right wherever it is given time.
inline constexpr const char* random_walks = "montecarlo";

/// What is done where a model errs more than is asked.
enum class Remedy { none, walks };  ///< walks: forward/choice/correction.h

struct Choice {
  std::vector<ModelCandidate> candidates;  ///< the one to take first, then by cost, then the others
  bool within_tolerance = false;    ///< the first is expected to err no more than the tolerance
  double seconds_per_photon = 0.0;  ///< of all channels' walks
};

/// `channels` are the same object in the media of its colour channels, which one model answers.
/// The tolerance is `asked`'s: of physics and numerics together. A model that is beyond it
/// counts with its remedy.
Choice choose_model(std::span<const ObjectFeatures> channels, const ObjectOptions& asked,
                    const MachineCosts& costs, Remedy remedy);

/// Orders the candidates by what is now known of them: within the tolerance by cost, beyond it by
/// error, then those of unknown error.
void rank(Choice& choice, double tolerance);

/// What to ask of a model for the error that choose_model() expects: half the tolerance of its
/// numerics; of `montecarlo` the tolerance, and the photons that bring its noise below it.
ObjectOptions options_for(const std::string& model, std::span<const ObjectFeatures> channels,
                          const ObjectOptions& asked);

}  // namespace kappamu::forward
