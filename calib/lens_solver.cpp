#include "calib/lens_solver.h"

#include <vector>

namespace kappamu::calib {

bool solve(ceres::Problem& problem, LensFit& fit) {
  const std::vector<int> fixed = fixed_numbers(fit.model);
  if (!fixed.empty()) {
    problem.SetManifold(fit.numbers.data(), new ceres::SubsetManifold(9, fixed));
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  fit.converged = summary.termination_type == ceres::CONVERGENCE;
  fit.residuals = static_cast<std::size_t>(problem.NumResiduals());
  fit.residual_sum_of_squares = 2.0 * summary.final_cost;
  return summary.IsSolutionUsable();
}

}  // namespace kappamu::calib
