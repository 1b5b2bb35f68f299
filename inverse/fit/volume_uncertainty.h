// How far fitted volumes can be trusted (inverse/uncertainty), after the fits of all channels: the
// volumes of one material share one prior.
#pragma once

#include <optional>
#include <span>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse {

/// The lowest of the fits' prior weights, that of the channel whose light reaches most of the
/// structure (docs/theory.md, 5). Empty where no fit has a prior.
std::optional<double> shared_prior_weight(std::span<const ChannelFit> fits);

/// Of `fit`, a volume with a prior, to `fitted`: the fit's r, the prior with the weight
/// `prior_weight`.
Uncertainty estimate_volume_uncertainty(const ChannelFit& fit, double prior_weight,
                                        const SurfaceMeasurements& fitted, int channel,
                                        const FitOptions& options);

}  // namespace kappamu::inverse
