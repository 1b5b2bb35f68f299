// How far a fitted volume's coefficients could be elsewhere if the block were of other layers. The
// fit smooths layers towards each other, so that its own deviations take their profile for known.
// Light of few lateral frequencies, above all on the lit face, does not determine the profile, and
// with it neither κ nor μ of any layer.
#pragma once

#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// Standard deviations of log κ and log μ in the layer that is known best.
struct LayerFreedom {
  double log_kappa = 0.0;
  double log_mu = 0.0;
};

/// The fields are changed by whole layers of equal depth; only layer_prior() (model_layers.h) and
/// the data hold them. Linearised at the fields of the objective's last value(): two tangent
/// solves per layer.
LayerFreedom layer_freedom(Objective& objective);

}  // namespace kappamu::inverse
