#include "inverse/optimise/settle_correction.h"

namespace kappamu::inverse {

double settle_correction(Eigen::VectorXd start, double tolerance, int most,
                         const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& refit) {
  constexpr double longest = 1.0;
  double move = 0.0;
  for (int k = 0; k < most; ++k) {
    const Eigen::VectorXd step = refit(start) - start;
    move = step.cwiseAbs().maxCoeff();
    if (move < tolerance) break;
    start += step.cwiseMax(-longest).cwiseMin(longest);
  }
  return move;
}

}  // namespace kappamu::inverse
