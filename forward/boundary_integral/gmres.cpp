#include "forward/boundary_integral/gmres.h"

#include <vector>

#include "core/numbers/linear_algebra.h"

namespace kappamu::forward::boundary_integral {

GmresReport gmres(const Map& a, const Eigen::VectorXd& b, const GmresLimits& limits,
                  Eigen::VectorXd& x) {
  GmresReport report;
  const double size = b.norm();
  if (size == 0.0) {
    x.setZero();
    report.converged = true;
    return report;
  }
  for (;;) {
    const Eigen::VectorXd residual = x.isZero(0.0) ? b : (b - a(x)).eval();
    const double start = residual.norm();
    report.residual = start / size;
    report.converged = report.residual <= limits.tolerance;
    if (report.converged || report.iterations >= limits.most_iterations) return report;
    // Arnoldi: A [v₁ … v_m] = [v₁ … v_m+1] H.
    std::vector<Eigen::VectorXd> basis{residual / start};
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(limits.restart + 1, limits.restart);
    Eigen::VectorXd weights;
    for (Eigen::Index m = 0; m < limits.restart; ++m) {
      Eigen::VectorXd next = a(basis.back());
      ++report.iterations;
      for (int pass = 0; pass < 2; ++pass) {
        for (Eigen::Index k = 0; k <= m; ++k) {
          const double along = basis[static_cast<std::size_t>(k)].dot(next);
          h(k, m) += along;
          next -= along * basis[static_cast<std::size_t>(k)];
        }
      }
      h(m + 1, m) = next.norm();
      Eigen::VectorXd first = Eigen::VectorXd::Zero(m + 2);
      first[0] = start;
      const Eigen::MatrixXd part = h.topLeftCorner(m + 2, m + 1);
      weights = least_squares(part, first);
      const double left = (first - part * weights).norm();
      if (left <= 0.5 * limits.tolerance * size || h(m + 1, m) <= 1e-14 * start ||
          report.iterations >= limits.most_iterations) {
        break;
      }
      basis.push_back(next / h(m + 1, m));
    }
    for (Eigen::Index k = 0; k < weights.size(); ++k) {
      x += weights[k] * basis[static_cast<std::size_t>(k)];
    }
  }
}

}  // namespace kappamu::forward::boundary_integral
