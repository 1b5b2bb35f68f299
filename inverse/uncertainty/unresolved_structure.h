// Bias of a fit's means by unresolved structure. Structure finer than the resolution changes the
// light to second order, and the fit answers with an even change of κ and μ. Its strength is
// unknown. An estimate is the change that the fit shows when it is smoothed by its own point spread
// once more; the true one is proportional to it (Tukey's twicing, 1977; docs/theory.md, 5).
#pragma once

#include "inverse/problem/objective.h"
#include "inverse/uncertainty/point_spread.h"
#include "inverse/uncertainty/prior.h"

namespace kappamu::inverse {

/// Change of log κ and log μ of all voxels together.
struct EvenChange {
  double log_kappa = 0.0;
  double log_mu = 0.0;
};

/// The change that brings the light of `fields`, smoothed over `spread`, back to that of `fields`,
/// as far as `prior` lets the fit change evenly: two values, two tangent solves. Leaves the
/// objective at `fields`. None where the smooth volume has no light.
EvenChange unresolved_structure(Objective& objective, const CoefficientPair& fields,
                                const PointSpread& spread, const Prior& prior);

}  // namespace kappamu::inverse
