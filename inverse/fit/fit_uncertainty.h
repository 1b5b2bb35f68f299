// How far fitted coefficients can be trusted, once the fits of all channels have ended: volumes of
// one material share one prior (inverse/uncertainty); homogeneous and layered blocks have few
// unknowns, so that C = (JᵀWJ + P)⁻¹ is exact, P being the weak prior of model_layers.h.
#pragma once

#include <optional>
#include <span>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse {

/// The lowest of the fits' prior weights and wave weights, those of the channel whose light reaches
/// most of the structure (docs/theory.md, 5). Empty where no fit has a prior.
std::optional<Prior> shared_prior(std::span<const ChannelFit> fits);

/// Of `fit`, a volume with a prior, to `fitted`: the fit's r and weight, and what it misses of
/// waves of the weights of `shared`, on a coarser grid; where that cannot be had, the weight of
/// `shared`.
Uncertainty estimate_volume_uncertainty(const ChannelFit& fit, const Prior& shared,
                                        const SurfaceMeasurements& fitted, int channel,
                                        const FitOptions& options);

/// Of `fit`, whose model is homogeneous or layered, to `fitted`: one tangent solve per unknown and
/// the correction anew. Every voxel has its layer's deviations; resolution is 1, since no smoothing
/// decides. That the block is of this kind, and the layers where they are, is taken for granted.
Uncertainty estimate_model_uncertainty(const ChannelFit& fit, const SurfaceMeasurements& fitted,
                                       int channel, const FitOptions& options);

/// The layers of a medium that is even across `axis`, voxels of equal values together.
LayeredMedium layers_of(const Medium& medium, int axis);

}  // namespace kappamu::inverse
