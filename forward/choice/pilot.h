// Short random walks on the very object: they measure a model's error there and correct its answer,
// until what is left is within the tolerance.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "forward/choice/choice.h"

namespace kappamu::forward {

struct Pilot {
  std::string model;
  std::uint64_t photons = 0;  ///< walked, per light
  double measured =
      0.0;            ///< the model's own error, of the worst channel and light; 0: hidden by noise
  double left = 0.0;  ///< of the corrected answer, expected at most
  bool within = false;                ///< the tolerance
  std::vector<ObjectResult> results;  ///< corrected, one per channel
};

/// Solves by the first candidate as long as it is one that walks shall correct: it answers if what
/// is left is within the tolerance, and falls behind the others if not. The candidates' reasons
/// state what was measured. The last pilot; none where the first candidate needs none.
std::optional<Pilot> run_pilot(std::span<const ObjectProblem> problems,
                               std::span<const ObjectFeatures> channels, const ChoiceOptions& asked,
                               Choice& choice, Progress& progress);

}  // namespace kappamu::forward
