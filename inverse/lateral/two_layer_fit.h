// μa and σs' of a layer of known thickness and of the half-space under it, both unknown, from the
// reflectance at several spatial frequencies: one answer for a region, by transport in layers.
#pragma once

#include <Eigen/Core>

#include "forward/lateral/layered_transport.h"
#include "inverse/lateral/lateral_fit.h"

namespace kappamu::inverse {

/// Transport mean free paths of an upper layer below which its deviations are too small: against
/// photons μa of the half-space was off by a factor of 1.6 at 0.2, six times its deviation
/// (MonteCarloTwoLayerFit).
inline constexpr double thin_layer = 0.5;

struct TwoLayerFit {
  LateralCoefficients upper, lower;
  /// Of ln μa and ln σs' of the upper layer, then of the lower one. What the data leave open is
  /// held by the prior: each coefficient within a factor of 4 of the start (one standard
  /// deviation).
  Eigen::Matrix4d covariance;
  double chi_square = 0.0;  ///< Σ (residual/deviation)², without the prior
  bool converged = false;

  /// Whether the data tell a coefficient (in the order of `covariance`) better than the prior by
  /// half.
  bool determined(Eigen::Index coefficient) const;
};

/// `reflectance` at each `frequency` [1/mm], `covariance` of their logarithms. `start` is the
/// homogeneous medium nearest to them.
TwoLayerFit fit_two_layers(const forward::LayeredTransport& transport, double thickness_mm,
                           const PerFrequency& frequency, const PerFrequency& reflectance,
                           const Eigen::MatrixXd& covariance, const LateralCoefficients& start);

}  // namespace kappamu::inverse
