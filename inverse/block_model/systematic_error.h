// Error that no noise explains: photographs interpolated between pixels, a pose, a response or a
// scale a little wrong. Neighbouring pixels share it where noise is white, so the products of
// residuals over lags of pixels show its size and correlation length (docs/theory.md, section 5).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// Error in the residuals s = √w (r M − d), whose noise has variance 1 where variances are right.
struct SystematicError {
  double variance = 0.0;        ///< of the part that neighbours share; at lag d this times
  double length = 1.0;          ///< exp(−d²/2 length²) [pixels]
  double variance_error = 0.0;  ///< standard deviation of `variance` under white noise alone
  double white = 1.0;           ///< variance of the rest, at least 1
  double relative = 0.0;        ///< the shared part over the values, root of weighted mean squares
  double excess = 0.0;          ///< the same of all beyond the stated variance

  /// Whether it exceeds white noise and `tolerated`, in units of the stated variances.
  bool found(double tolerated) const;
};

/// The prediction r M [M][v][u] and its r.
struct CorrectedPrediction {
  const std::vector<double>& value;
  const std::vector<double>& ratio;
  bool ratio_is_of_grid = true;  ///< r is the finer grid's answer over this one's, nothing else
};

/// The grid's own error, which the prediction on two grids shows (Richardson), is taken out first.
SystematicError estimate_systematic_error(const Problem& problem,
                                          const CorrectedPrediction& prediction);

/// Covariance of the residuals: white noise, `error`, and errors that all pixels share, of scale,
/// response exponent and shift in u and v, each with a standard deviation of `common` relative to
/// the values.
class ErrorCovariance {
 public:
  ErrorCovariance(const Problem& problem, const std::vector<double>& prediction,
                  const SystematicError& error, double common);

  /// Jᵀ Σ J of rows J [k][unknown] of the residuals `rows`.
  Eigen::MatrixXd between(const Eigen::MatrixXd& jacobian,
                          const std::vector<std::size_t>& rows) const;

  /// Residual [k] of `rows` less what unknowns of Jacobian `jacobian` and the errors that all
  /// pixels share explain together.
  Eigen::VectorXd without_common(const Eigen::VectorXd& residual, const Eigen::MatrixXd& jacobian,
                                 const std::vector<std::size_t>& rows) const;

  /// Residuals of this covariance [M][v][u], 0 where masked.
  std::vector<double> draw(std::mt19937_64& engine) const;

 private:
  const Problem& problem_;
  SystematicError error_;
  Eigen::MatrixXd along_u_, along_v_;        ///< rows of unit length; products correlate as stated
  std::vector<std::vector<double>> common_;  ///< [M][v][u] each
};

/// How much more of the residuals voxels could explain than of errors of covariance `errors`: mean
/// over coefficients and slices of the gradient's square over that expected of such errors. About 1
/// where the residuals are of their kind; structure, which all patterns show, gives more.
/// `residual` is that of the objective's last value(); one adjoint solve and `draws`.
double structure_ratio(Objective& objective, const std::vector<double>& residual,
                       const ErrorCovariance& errors, int draws, std::uint64_t seed);

/// Rise of χ² that errors of covariance `between` (Jᵀ Σ J) make by chance when unknowns become
/// `copies` of fewer: its mean and standard deviation. `normal` is JᵀJ with its prior.
struct ChanceRise {
  double mean = 0.0;
  double deviation = 0.0;
};
ChanceRise chance_rise(const Eigen::MatrixXd& normal, const Eigen::MatrixXd& between,
                       const Eigen::MatrixXd& copies);

}  // namespace kappamu::inverse
