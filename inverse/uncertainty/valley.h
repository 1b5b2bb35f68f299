// What no linear look about a fit shows of its errors. Steady light hardly tells κ from μ: volumes
// of one η = μ/κ + Δ√κ/√κ look alike (Arridge & Lionheart 1998), so that fit and truth lie in one
// bent, flat valley of the objective. How far apart they lie there hardly depends on the noise; it
// was measured on blocks of known truth and grows with the contrast that is found (docs/theory.md,
// 5).
#pragma once

#include "core/grid.h"

namespace kappamu::inverse {

/// Standard deviation of log κ along the valley [dimensionless], of the κ of a fitted volume; that
/// of log μ is `absorbers_vary` (roughness.h) times as large.
double valley_deviation(const Volume<double>& kappa, Face lit);

}  // namespace kappamu::inverse
