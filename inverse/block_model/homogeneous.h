// Where a fit starts: the homogeneous block that comes closest, two parameters for all voxels.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// A start of the user's own, beside the table's.
struct HomogeneousGuess {
  double kappa = 0.0;  ///< [mm]
  double mu = 0.0;     ///< [1/mm]
};

struct HomogeneousFit {
  double kappa = 0.0;         ///< [mm]
  double mu = 0.0;            ///< [1/mm]
  double log_residual = 0.0;  ///< root mean square of log M − log d over the data used
  /// Standard deviations of log κ and log μ, what structure leaves of a pattern's residuals taken
  /// as common to its pixels.
  Eigen::Vector2d deviation = Eigen::Vector2d::Zero();
  bool converged = false;
  /// Derivatives of the residuals on a grid by log κ and log μ near the end; a new correction r of
  /// the grid leaves them valid. Empty: no grid was solved on.
  Eigen::MatrixXd jacobian;

  /// log κ and log μ.
  Eigen::Vector2d logs() const { return {std::log(kappa), std::log(mu)}; }
};

/// The block with the least sum of squares of log M − log d over the data above three standard
/// deviations. Light on the seen face may leave several minima, so the search starts from the
/// lowest points of a table of (κ, μ) and from `guess`, by Levenberg-Marquardt. The table spans
/// marble to milk to wax at any size of block. With logarithms the descent finds its way from
/// starts far from the minimum. Predictions come from the block's lateral modes
/// (forward/analytic/homogeneous_block.h) at some 8000 data, without a grid and its error. Thin
/// blocks of low absorption and blocks with structure do not determine μ: there a weak prior on
/// 3κμ, the absorbed share of collisions, does. Throws InputError when no datum exceeds its noise.
HomogeneousFit find_homogeneous(const Problem& problem,
                                const std::optional<HomogeneousGuess>& guess = std::nullopt);

/// The block next to `from` that suits the objective's own grid with its correction.
HomogeneousFit refit_homogeneous(Objective& objective, const HomogeneousFit& from);

}  // namespace kappamu::inverse
