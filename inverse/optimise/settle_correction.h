// A fit whose correction r holds where it was made: r is made where the fit led, until both agree.
#pragma once

#include <Eigen/Core>

namespace kappamu::inverse {

/// From `start`: `refit(p)` makes r at p and returns where the data then lead; the next p is that,
/// by at most 1 in any unknown [log units], until it is less than `tolerance` away or `most` refits
/// are done. Returns how far the last refit led.
template <class Refit>
double settle_correction(Eigen::VectorXd start, double tolerance, int most, const Refit& refit) {
  double move = 0.0;
  for (int k = 0; k < most; ++k) {
    const Eigen::VectorXd step = refit(start) - start;
    move = step.cwiseAbs().maxCoeff();
    if (move < tolerance) break;
    start += step.cwiseMax(-1.0).cwiseMin(1.0);
  }
  return move;
}

}  // namespace kappamu::inverse
