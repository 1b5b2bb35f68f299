// Least squares over a lens and whatever poses go with it, for camera and projector alike.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "calib/lens/camera.h"
#include "calib/lens/lens_model.h"

namespace ceres {
class Problem;
}

namespace kappamu::calib {

/// To `problem`, on the lens numbers it refers to.
void add_prior(ceres::Problem& problem, const LensPrior& prior, LensNumbers& numbers);

/// Holds the numbers of the indices `fixed` where they are.
void hold(ceres::Problem& problem, double* lens, const std::vector<int>& fixed);

/// A lens fitted to observations, and how well.
struct LensFit {
  LensModel model = LensModel::pinhole_square;
  LensNumbers numbers{};
  double residual_sum_of_squares = 0.0;
  std::size_t residuals = 0;
  bool converged = false;
  LensCovariance covariance = LensCovariance::Zero();
};

/// Minimises `problem`, whose residuals refer to fit.numbers, with the numbers held that fit.model
/// holds fixed. Sets all of `fit` but the covariance; false if the result is of no use.
/// `tolerance` is relative, on cost, parameters and gradient.
[[nodiscard]] bool solve(ceres::Problem& problem, LensFit& fit, double tolerance = 1e-12,
                         int max_iterations = 200);

}  // namespace kappamu::calib
