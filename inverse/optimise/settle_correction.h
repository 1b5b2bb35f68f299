// A fit whose correction r holds where it was made: r is made where the fit led, until both agree.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace kappamu::inverse {

/// From `start`: `refit(p)` makes r at p and returns where the data then lead; the next p is that,
/// by at most 1 in any unknown [log units], until it is less than `tolerance` away or `most` refits
/// are done. Returns how far the last refit led.
double settle_correction(Eigen::VectorXd start, double tolerance, int most,
                         const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& refit);

}  // namespace kappamu::inverse
