// Where a fit starts: the homogeneous block that comes closest, two parameters for all voxels.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// A start of the user's own, beside the table of guesses.
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
  /// Of the residuals by log κ and log μ, near the end: a correction of the grid does not change
  /// it.
  Eigen::MatrixXd jacobian;

  /// log κ and log μ.
  Eigen::Vector2d logs() const { return {std::log(kappa), std::log(mu)}; }
};

/// Levenberg-Marquardt on log M − log d over the data above three standard deviations, from the
/// best of a table of guesses that spans marble to milk to wax at any size of block, and from
/// `guess`: one that is off by 100 times then costs its descent and nothing else. The logarithm
/// makes all guesses, however far off, slope towards the solution. A thin block that hardly absorbs
/// does not tell μ, and one with structure may seem to absorb nothing: a weak prior on the absorbed
/// share of collisions, 3κμ, decides there. Uses the objective's correction. Throws InputError when
/// no datum stands above its noise.
HomogeneousFit fit_homogeneous(Objective& objective,
                               const std::optional<HomogeneousGuess>& guess = std::nullopt);

/// The same from where `from`, a fit to the same data with another correction, ended.
HomogeneousFit refit_homogeneous(Objective& objective, const HomogeneousFit& from);

}  // namespace kappamu::inverse
