// A fit that some patterns judge, and that then takes them in again: with one pattern of sixteen
// kept out E under other light is 1.4 to 3 times higher (docs/theory.md, section 4).
#pragma once

#include <optional>
#include <span>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"
#include "inverse/problem/held_out.h"

namespace kappamu::inverse {

struct JudgedInput {
  const SurfaceMeasurements& all;
  SurfaceMeasurements fitted;                   ///< what the judged fit sees
  std::optional<SurfaceMeasurements> held_out;  ///< what judges it
  bool rejoin = false;                          ///< held_out are patterns of `all`
};

/// `patterns` of `all` are kept out, or none of them where measurements `apart` judge the fit.
JudgedInput keep_out(const SurfaceMeasurements& all, std::span<const int> patterns,
                     std::optional<SurfaceMeasurements> apart = std::nullopt);

struct JudgedFit {
  ChannelFit fit;
  std::optional<HeldOutScore> score;  ///< of volumes that did not see the held-out light
  std::optional<Medium> judged;       ///< those volumes, where `fit` has seen it since
};

/// fit_channel() without what is held out, the simplest model that held-out light prefers
/// (model_held_out.h), its score; then, where a volume was fitted and patterns can rejoin, one more
/// minimisation at the weight found, of all patterns. Checkpoints are of the first fit and of that
/// one; `continued` is where the first starts. The report tells both, solves and seconds added up.
JudgedFit fit_judged(const JudgedInput& input, int channel, const FitOptions& options,
                     const Checkpoint& first, const Checkpoint& second, Progress& progress,
                     const Observer& observer = {},
                     const std::optional<Continuation>& continued = std::nullopt);

}  // namespace kappamu::inverse
