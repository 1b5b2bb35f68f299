// Few unknowns that a correction r depends on: x ← g(x), g being what is fitted with r made at x.
// Where photons make r (objective.h) the plain iteration creeps, or even leaves, in blocks far from
// diffusion.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace kappamu::inverse {

/// Anderson's acceleration (Walker & Ni 2011), of all pairs so far: with as many pairs as unknowns
/// and one the secant method.
class FixedPoint {
 public:
  /// From `x` and `g`, found with r made at x: where to make r next. No component is further than
  /// 0.7 from g's [log units]. Where an accelerated step leads astray (a residual of four times the
  /// least) it begins again from the g of the least.
  Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& g);

 private:
  std::vector<Eigen::VectorXd> x_, f_;  ///< f = g(x) − x
  Eigen::VectorXd best_;                ///< g of the least residual
  double least_move_ = 0.0;             ///< that residual, largest component
};

}  // namespace kappamu::inverse
