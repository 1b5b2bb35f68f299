// How far fitted coefficients can be trusted, once the fits of all channels have ended: volumes of
// one material share one contrast (inverse/uncertainty/shared_deviation.h); homogeneous and layered
// blocks have few unknowns, so that C = (JᵀWJ + P)⁻¹ is exact, P being the weak prior of
// model_layers.h.
#pragma once

#include <optional>
#include <span>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse {

/// The largest contrast_deviation(), unresolved structure and layer freedom of the volumes serve
/// all: channels share one material, and light that is absorbed early finds too little of its
/// contrast (docs/theory.md, 5).
SharedDeviation shared_deviation(std::span<const ChannelFit> fits, Face lit);

/// Deviations of `fit`, a volume with a prior, to `fitted`: C with the fit's weight, and `shared`.
/// Needs no further solve.
Uncertainty estimate_volume_uncertainty(const ChannelFit& fit, const SharedDeviation& shared,
                                        const SurfaceMeasurements& fitted);

/// Deviations of `fit`, whose model is homogeneous or layered, to `fitted`: one tangent solve per
/// unknown and the correction anew. Every voxel has its layer's deviations; resolution is 1, since
/// no smoothing decides. That the block is of this kind, and the layers where they are, is taken
/// for granted.
Uncertainty estimate_model_uncertainty(const ChannelFit& fit, const SurfaceMeasurements& fitted,
                                       int channel, const FitOptions& options);

/// The layers of a medium that is even across `axis`, voxels of equal values together.
LayeredMedium layers_of(const Medium& medium, int axis);

}  // namespace kappamu::inverse
