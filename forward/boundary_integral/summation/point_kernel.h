// G = e^−λr/(4πr) from many sources at a point, in vector instructions.
#pragma once

#include <Eigen/Core>
#include <numbers>

namespace kappamu::forward::boundary_integral {

/// At distances r [mm]; `decay` λ [1/mm].
template <class Distances>
auto greens_function(const Distances& r, double decay) {
  return ((-decay * r).exp() / (4.0 * std::numbers::pi * r)).eval();
}

/// Points, each with a charge and a dipole.
struct PointSources {
  Eigen::ArrayX3d at, dipole;  ///< [mm]; of no rows: no dipoles
  Eigen::ArrayXd charge;

  /// What each of [begin, end) adds to the potential at x: charge · G + dipole · ∇_y G. A source at
  /// x itself adds nothing.
  Eigen::ArrayXd potentials(const Eigen::Vector3d& x, Eigen::Index begin, Eigen::Index end,
                            double decay) const {
    const Eigen::Index n = end - begin;
    const Eigen::ArrayXd dx = x.x() - at.col(0).segment(begin, n);
    const Eigen::ArrayXd dy = x.y() - at.col(1).segment(begin, n);
    const Eigen::ArrayXd dz = x.z() - at.col(2).segment(begin, n);
    const Eigen::ArrayXd r2 = dx * dx + dy * dy + dz * dz;
    const Eigen::ArrayXd r = r2.sqrt();
    const Eigen::ArrayXd g = greens_function(r, decay);
    Eigen::ArrayXd sum = charge.segment(begin, n) * g;
    if (dipole.rows() > 0) {
      sum += (dx * dipole.col(0).segment(begin, n) + dy * dipole.col(1).segment(begin, n) +
              dz * dipole.col(2).segment(begin, n)) *
             (1.0 + decay * r) * g / r2;
    }
    return (r2 > 0.0).select(sum, 0.0);
  }
};

}  // namespace kappamu::forward::boundary_integral
