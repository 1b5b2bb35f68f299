#include "calib/lens/lens_solver.h"

#include <ceres/ceres.h>

#include <vector>

namespace kappamu::calib {

void add_prior(ceres::Problem& problem, const LensPrior& prior, LensNumbers& numbers) {
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<LensPrior, 4, lens_numbers>(new LensPrior(prior)), nullptr,
      numbers.data());
}

void hold(ceres::Problem& problem, double* lens, const std::vector<int>& fixed) {
  if (fixed.size() == lens_numbers) {
    problem.SetParameterBlockConstant(lens);
  } else if (!fixed.empty()) {
    problem.SetManifold(lens, new ceres::SubsetManifold(lens_numbers, fixed));
  }
}

bool solve(ceres::Problem& problem, LensFit& fit, double tolerance, int max_iterations) {
  hold(problem, fit.numbers.data(), fixed_numbers(fit.model));
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = tolerance;
  options.parameter_tolerance = tolerance;
  options.gradient_tolerance = tolerance;
  // Coefficients that the views do not tell apart (k1 and k4 of a lens that needs neither) would
  // make the normal equations singular without a least damping.
  options.max_trust_region_radius = 1e8;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  fit.converged = summary.termination_type == ceres::CONVERGENCE;
  fit.residuals = static_cast<std::size_t>(problem.NumResiduals());
  fit.residual_sum_of_squares = 2.0 * summary.final_cost;
  return summary.IsSolutionUsable();
}

}  // namespace kappamu::calib
