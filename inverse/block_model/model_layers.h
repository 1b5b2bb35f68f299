// Models of few unknowns: a block of even layers across the light, one (κ, μ) each. One layer is
// the homogeneous block. Fitted by Gauss-Newton to the weighted data themselves, not to their
// logarithms as the start of a fit is (homogeneous.h): at the noise level this is maximum
// likelihood.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "inverse/block_model/block_model.h"
#include "inverse/block_model/systematic_error.h"
#include "inverse/optimise/levenberg_marquardt.h"
#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// log κ of the layers, then log μ; and the medium of other values for them.
Eigen::VectorXd unknowns(const LayeredMedium& medium);
LayeredMedium with_unknowns(LayeredMedium medium, const Eigen::VectorXd& unknowns);

/// Unknowns of `many` layers from those of `few`, whose borders are among theirs.
Eigen::MatrixXd copies(const LayeredMedium& many, const LayeredMedium& few);

/// Neighbouring layers of `medium` joined, most alike first, while that is expected to raise χ² by
/// no more than `allowance` altogether. `normal`: JᵀWJ by the unknowns, at a minimum of χ². To
/// second order; fit the result anew.
LayeredMedium merge_layers(const LayeredMedium& medium, const Eigen::MatrixXd& normal,
                           double allowance);

/// Values of every voxel.
CoefficientPair to_fields(const LayeredMedium& medium, const MediumSpace& space);

/// `layers` of equal depth up to rounding, in `depth` slices, with the values that `coarse` has at
/// their middle. Twice the layers of a medium made this way lie within its own.
LayeredMedium with_layers(const LayeredMedium& coarse, int layers, int depth);

/// A weak prior decides what the data leave open of log κ of the layers, then log μ: those of
/// neighbouring layers differ by 1 (one standard deviation), log 3κμ is that of `start` within 2.
LinearPrior layer_prior(const LayeredMedium& start);

struct LayeredFit {
  LayeredMedium medium;
  double chi2_per_value = 0.0;
  int steps = 0;
  bool converged = false;
};

/// Keeps its Jacobian, so that descending again from where it is, with another correction of the
/// objective or after a step, costs few solves: 2 per layer for a Jacobian, one per step, which
/// Broyden's update turns into the next Jacobian.
class LayerFitter final : private Residuals {
 public:
  LayerFitter(Objective& objective, const LayeredMedium& start);

  /// Minimises ½ χ² + layer_prior() from where the last call ended. Gives up, unconverged, where χ²
  /// per datum would stay above `useful` even if a step kept several times its promise.
  LayeredFit descend(double useful = 0.0);
  /// To be called when the slope of the objective's correction has changed.
  void forget_derivatives() { at_.jacobian.resize(0, 0); }

  /// JᵀWJ and the prior's share with respect to log κ of the layers, then log μ, after descend().
  Eigen::MatrixXd normal() const;
  /// Covariance of the slope JᵀWr under errors of the data of covariance `errors`, the prior's
  /// share with it: normal() where errors are noise as stated.
  Eigen::MatrixXd slope_covariance(const ErrorCovariance& errors) const;

  /// Residuals where the last descent ended [M][v][u], 0 where masked, less what layers and errors
  /// that all pixels share explain of them.
  std::vector<double> residual_without_common(const ErrorCovariance& errors);

  /// Inverse of normal() where it is now, its Jacobian fresh: two solves per layer.
  Eigen::MatrixXd covariance();
  /// The same where errors of the data have the covariance `errors`, which the fit does not weigh.
  Eigen::MatrixXd covariance(const ErrorCovariance& errors);

 private:
  Eigen::VectorXd residual(const Eigen::VectorXd& p) override;
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& p) override;
  /// Residuals where it is now.
  const Eigen::VectorXd& evaluate();
  CoefficientPair fields(const Eigen::VectorXd& p) const;
  LayeredMedium medium(const Eigen::VectorXd& p) const { return with_unknowns(start_, p); }

  Objective& objective_;
  LayeredMedium start_;
  std::vector<std::size_t> used_;  ///< data with weight
  LinearPrior prior_;
  LeastSquaresState at_;  ///< p: log κ of the layers, then log μ; Jacobian [used][p]
};

}  // namespace kappamu::inverse
