// What structure finer than a fit resolves does to its means. Light goes by the whole volume, which
// is not that of its smooth part: what is missed changes it to second order, and the fit answers
// with an even change of κ and μ. How strong it is cannot be seen; a fit that is smoothed by its
// own point spread once more misses of itself about as much as it does of the truth, in proportion
// (Tukey's twicing, 1977; docs/theory.md, 5).
#pragma once

#include "inverse/problem/objective.h"
#include "inverse/uncertainty/point_spread.h"
#include "inverse/uncertainty/prior.h"

namespace kappamu::inverse {

/// Of log κ and log μ of all voxels together.
struct EvenChange {
  double log_kappa = 0.0;
  double log_mu = 0.0;
};

/// The change that brings the light of `fields`, smoothed over `spread`, back to that of `fields`,
/// as far as `prior` lets the fit change evenly: two values, two tangent solves. Leaves the
/// objective at `fields`. None where the smooth volume has no light.
EvenChange missed_structure(Objective& objective, const CoefficientPair& fields,
                            const PointSpread& spread, const Prior& prior);

}  // namespace kappamu::inverse
