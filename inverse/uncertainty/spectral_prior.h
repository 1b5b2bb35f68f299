// The regulariser α R of H1 as a prior whose weight may differ from one spatial frequency to the
// next. R charges the square of the frequency; materials are smoother than that over a few voxels
// and rougher over many. The weight of a band of frequencies is therefore lowered to the one that
// expects what the fit found there (docs/theory.md, section 5).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "inverse/optimise/basis.h"
#include "inverse/optimise/lateral_modes.h"

namespace kappamu::inverse {

struct Prior;

/// Diagonal in cosines along all three axes; log μ may vary `absorbers_vary` times as much as log
/// κ.
class SpectralPrior {
 public:
  /// `prior.weight` in every band. `depth_axis` as LateralModes has it.
  SpectralPrior(const GridShape& shape, int depth_axis, const Prior& prior);

  /// Gaussian fields that the data determine in γ directions have 2 α R = γ in expectation at the
  /// minimum (MacKay 1992): lowers each band's α to that of log κ, never raises it. At least one
  /// direction counts as determined: fewer say nothing. Of log μ the data often determine a
  /// handful, which says as little. `log_kappa` is the fitted one less the anchor's, `blocks` the
  /// data's Hessian.
  void bear_out(const Vector& log_kappa, const LateralBlocks& blocks);

  double least_weight() const;
  /// α R″ v.
  CoefficientPair product(const CoefficientPair& v) const;
  /// α R″ as a matrix per bin of lateral frequency, the mean of its waves.
  LateralBlocks precision() const;
  /// Diagonal of (α R″)⁻¹.
  CoefficientPair variance() const;

 private:
  /// Of a wave at a frequency along the depth: α, and R″ for log κ.
  double weight(int wave, Eigen::Index along_depth) const {
    return weights_[band(wave, along_depth)];
  }
  double square(int wave, Eigen::Index along_depth) const;
  std::size_t band(int wave, Eigen::Index along_depth) const;
  /// α R″ of every wave [rows][waves], frequencies along the depth in place of depths.
  Eigen::MatrixXd spectrum() const;

  LateralModes modes_;
  Eigen::MatrixXd cosines_;  ///< orthonormal, [frequency][depth]
  double scale_;             ///< h/ℓ
  double pull_;              ///< (h/L)²
  double longest_;  ///< extent of the block [voxels]: bands are as wide as its lowest frequency
  std::vector<double> weights_;  ///< α by band
};

}  // namespace kappamu::inverse
