// A fit that some patterns validate, and that then takes them in again: with one of sixteen
// kept out E under other light is 1.4 to 3 times higher (docs/theory.md, section 4).
#pragma once

#include <optional>
#include <span>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"
#include "inverse/validation/validation_patterns.h"

namespace kappamu::inverse {

struct ValidationSplit {
  const SurfaceMeasurements& all;
  SurfaceMeasurements fitted;                     ///< what the validated fit sees
  std::optional<SurfaceMeasurements> validation;  ///< what validates it
  bool rejoin = false;                            ///< validation are patterns of `all`
};

/// `patterns` of `all` are kept out, or none of them where measurements `apart` validate the fit.
ValidationSplit split_validation(const SurfaceMeasurements& all, std::span<const int> patterns,
                                 std::optional<SurfaceMeasurements> apart = std::nullopt);

struct ValidatedFit {
  ChannelFit fit;
  std::optional<ValidationScore> score;  ///< of volumes that did not see the validation patterns
  std::optional<Medium> validated;       ///< those volumes, where `fit` has seen it since
};

/// fit_channel() without what is kept out, the simplest model that validation prefers
/// (simpler_model.h), its score; then, where a volume was fitted and patterns can rejoin, one more
/// minimisation at the weight found, of all patterns. Checkpoints are of the first fit and of that
/// one; `continued` is where the first starts. The report covers both, with solves and seconds
/// added up.
ValidatedFit fit_validated(const ValidationSplit& input, int channel, const FitOptions& options,
                           const Checkpoint& first, const Checkpoint& second, Progress& progress,
                           const Observer& observer = {},
                           const std::optional<Continuation>& continued = std::nullopt);

}  // namespace kappamu::inverse
