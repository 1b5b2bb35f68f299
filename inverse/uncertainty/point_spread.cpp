#include "inverse/uncertainty/point_spread.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::point_spread;

/// exp(−λ w²/2) = ½ at the eigenvalue λ, between two bins, where `found` first falls below ½, and
/// √(8 ln 2) w, both in voxels.
double full_width(const Eigen::VectorXd& found, const Eigen::VectorXd& eigenvalue, double longest) {
  const auto below =
      std::find_if(found.begin(), found.end(), [](double f) { return f < half_found; });
  if (below == found.end()) return 0.0;
  const Eigen::Index bin = below - found.begin();
  if (bin == 0) return longest;
  const double part = (found(bin - 1) - half_found) / (found(bin - 1) - found(bin));
  const double at = std::lerp(eigenvalue(bin - 1), eigenvalue(bin), part);
  return std::min(longest, 4.0 * std::numbers::ln2 / std::sqrt(at));
}

}  // namespace

PointSpread point_spread(const Basis& prior, const Basis& posterior, const MediumSpace& space) {
  const GridShape& shape = space.shape;
  const LateralModes modes(space);
  const Eigen::MatrixXd found =
      1.0 - posterior.wave_variances().array() / prior.wave_variances().array();
  Eigen::VectorXd eigenvalue(modes.bins());
  for (int bin = 0; bin < modes.bins(); ++bin) eigenvalue(bin) = modes.mean_laplacian(bin);
  const double longest = std::max({shape.nx, shape.ny, shape.nz});
  PointSpread spread;
  for (int row = 0; row < modes.rows(); ++row) {
    Vector& widths = row < modes.depth() ? spread.kappa_mm : spread.mu_mm;
    widths.push_back(shape.voxel_mm * full_width(found.row(row), eigenvalue, longest));
  }
  return spread;
}

}  // namespace kappamu::inverse
