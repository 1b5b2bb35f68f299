// Notes and warnings on a finished fit that its χ² does not show.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"
#include "inverse/validation/validation_patterns.h"

namespace kappamu::inverse {

/// A warning if much of the seen face is measured under no pattern; `fitted` is what `fit` was made
/// of.
std::optional<std::string> unseen_warning(const ChannelFit& fit, const SurfaceMeasurements& fitted,
                                          int channel);

/// A warning if a few values far from the fit make most of its χ², with the pattern that has most
/// of them, if one has, counted as before the patterns `kept_out` (rising) were taken away.
std::optional<std::string> outlier_warning(const ChannelFit& fit, const SurfaceMeasurements& fitted,
                                           int channel, std::span<const int> kept_out = {});

/// Nothing of this is wrong: why diffusion or transport was taken, what the check of scale and pose
/// found and would have reported, voxels far below the mean free path, and a misfit of the
/// `validation` patterns, if any, that the fitted light and its variances do not explain.
std::vector<std::string> notes_on(const ChannelFit& fit, const SurfaceMeasurements& fitted,
                                  const std::optional<ValidationScore>& validation = {});

}  // namespace kappamu::inverse
