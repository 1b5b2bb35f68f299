// How far the coefficients of a homogeneous or layered block can be trusted: few unknowns, so that
// C = (JᵀWJ + P)⁻¹ is exact, P being the weak prior of model_layers.h.
#pragma once

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse {

/// Of `fit`, whose model is homogeneous or layered, to `fitted`: one tangent solve per unknown and
/// the correction anew. Every voxel has its layer's deviations; resolution is 1, since no smoothing
/// decides. That the block is of this kind, and the layers where they are, is taken for granted.
Uncertainty estimate_model_uncertainty(const ChannelFit& fit, const SurfaceMeasurements& fitted,
                                       int channel, const FitOptions& options);

/// The layers of a medium that is even across `axis`, voxels of equal values together.
LayeredMedium layers_of(const Medium& medium, int axis);

}  // namespace kappamu::inverse
