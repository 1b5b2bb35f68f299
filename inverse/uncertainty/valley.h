// What no linear look about a fit shows of its errors, common to the whole block. Steady light
// hardly tells κ from μ: volumes of one η = μ/κ + Δ√κ/√κ look alike (Arridge & Lionheart 1998), so
// that fit and truth lie in one bent, flat valley of the objective. How far apart they lie there
// hardly depends on the noise; it was measured on blocks of known truth and grows with the contrast
// that is found. Beside it what stands for structure that is missed (missed_structure.h;
// docs/theory.md, 5).
#pragma once

#include "core/grid.h"
#include "inverse/uncertainty/missed_structure.h"

namespace kappamu::inverse {

/// Standard deviations of log κ and log μ [dimensionless].
struct SharedDeviation {
  double log_kappa = 0.0;
  double log_mu = 0.0;
};

/// Of log κ along the valley, of the κ of a fitted volume.
double valley_deviation(const Volume<double>& kappa, Face lit);

/// Of a valley_deviation() and a missed_structure(), whatever their signs.
SharedDeviation shared_deviation(double valley, const EvenChange& missed);

}  // namespace kappamu::inverse
