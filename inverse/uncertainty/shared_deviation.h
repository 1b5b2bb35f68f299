// Errors of a fit that its linearised posterior does not contain; all voxels share them. Steady
// light determines κ against μ weakly: volumes of equal η = μ/κ + Δ√κ/√κ give nearly equal light
// (Arridge & Lionheart 1998). The distance between fit and truth along that direction was measured
// on blocks of known truth. It grows with the contrast found and depends little on the noise.
// Unresolved structure adds to it (unresolved_structure.h; docs/theory.md, 5).
#pragma once

#include <cstddef>
#include <vector>

#include "core/grid.h"
#include "inverse/uncertainty/unresolved_structure.h"

namespace kappamu::inverse {

/// Standard deviations of log κ and log μ [dimensionless].
struct SharedDeviation {
  double log_kappa = 0.0;
  double log_mu = 0.0;
  /// What a slice along the depth axis has at least; empty: nothing.
  std::vector<double> slice_log_kappa{}, slice_log_mu{};

  double kappa_at(std::size_t slice) const;
  double mu_at(std::size_t slice) const;
};

/// Standard deviation of log κ along the weakly determined direction, from the contrast of a fitted
/// κ.
double contrast_deviation(const Volume<double>& kappa, Face lit);

/// Of a contrast_deviation() and an unresolved_structure(); signs do not matter.
SharedDeviation shared_deviation(double contrast, const EvenChange& unresolved);

}  // namespace kappamu::inverse
