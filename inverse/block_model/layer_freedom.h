// How far a fitted volume's coefficients could be elsewhere if the block had another profile along
// the depth. The fit smooths layers towards each other, so that its own deviations take the profile
// for known. Light of few lateral frequencies, above all on the seen face, does not determine it.
#pragma once

#include <vector>

#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// Standard deviations of log κ and log μ by slice along the depth axis [dimensionless]; empty: not
/// estimated.
struct LayerFreedom {
  std::vector<double> log_kappa, log_mu;

  /// Of μ in the slice that is known best; 0 where it was not estimated.
  double least_log_mu() const;
  /// Slice by slice the larger one.
  void widen(const LayerFreedom& other);
};

/// The fields may change by whole layers of equal depth, which only the data and layer_prior()
/// (model_layers.h) hold. Slices and layers are those of the fit's block; `objective` may be of
/// voxels of twice the edge. Linearised at the fields of its last value(): two tangent solves per
/// layer (docs/theory.md, 5).
LayerFreedom layer_freedom(Objective& objective, const MediumSpace& block);

}  // namespace kappamu::inverse
