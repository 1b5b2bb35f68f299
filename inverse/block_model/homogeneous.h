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
  /// Of the residuals on a grid by log κ and log μ, near the end: a correction of the grid does not
  /// change it. Empty: none was solved on yet.
  Eigen::MatrixXd jacobian;

  /// log κ and log μ.
  Eigen::Vector2d logs() const { return {std::log(kappa), std::log(mu)}; }
};

/// The block whose log M comes closest to log d over the data above three standard deviations, in
/// the least of all valleys: a table of (κ, μ) that spans marble to milk to wax at any size of
/// block, then Levenberg-Marquardt from the table's lowest points and from `guess`. Light on the
/// seen face may leave several valleys. The logarithm makes all
/// places, however far off, slope towards a solution. Predictions are those of the block's lateral
/// modes (forward/analytic/homogeneous_block.h) at some 8000 data: no grid is solved on, and
/// none blurs the light. A thin block that hardly absorbs does not tell μ, and one with structure
/// may seem to absorb nothing: a weak prior on the absorbed share of collisions, 3κμ, decides
/// there. Throws InputError when no datum stands above its noise.
HomogeneousFit find_homogeneous(const Problem& problem,
                                const std::optional<HomogeneousGuess>& guess = std::nullopt);

/// The block next to `from` that suits the objective's own grid with its correction.
HomogeneousFit refit_homogeneous(Objective& objective, const HomogeneousFit& from);

}  // namespace kappamu::inverse
