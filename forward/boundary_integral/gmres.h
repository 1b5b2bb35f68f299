// Generalised minimal residuals (Saad & Schultz 1986), restarted.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace kappamu::forward::boundary_integral {

using Map = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

struct GmresReport {
  int iterations = 0;
  double residual = 0.0;  ///< ‖b − A x‖/‖b‖
  bool converged = false;
};

struct GmresLimits {
  double tolerance = 1e-6;  ///< of the relative residual
  int most_iterations = 200;
  int restart = 50;
};

/// Improves x in A x = b.
GmresReport gmres(const Map& a, const Eigen::VectorXd& b, const GmresLimits& limits,
                  Eigen::VectorXd& x);

}  // namespace kappamu::forward::boundary_integral
