#include "inverse/block_model/fixed_point.h"

#include <Eigen/Dense>

namespace kappamu::inverse {

namespace {

constexpr double longest = 0.7;  // log units
constexpr double astray = 4.0;   // times the least residual so far

}  // namespace

Eigen::VectorXd FixedPoint::next(const Eigen::VectorXd& x, const Eigen::VectorXd& g) {
  const Eigen::VectorXd f = g - x;
  const double move = f.cwiseAbs().maxCoeff();
  const bool full = static_cast<Eigen::Index>(x_.size()) > x.size();
  if (full && move > astray * least_move_) {  // differences were noise: begin again from the best
    x_.clear();
    f_.clear();
    return best_;
  }
  if (x_.empty() || move < least_move_) {
    least_move_ = move;
    best_ = g;
  }
  x_.push_back(x);
  f_.push_back(f);
  if (static_cast<Eigen::Index>(x_.size()) > x.size() + 1) {
    x_.erase(x_.begin());
    f_.erase(f_.begin());
  }
  const auto pairs = static_cast<Eigen::Index>(x_.size()) - 1;
  if (pairs == 0) return g;
  Eigen::MatrixXd dx(x.size(), pairs), df(x.size(), pairs);
  for (Eigen::Index k = 0; k < pairs; ++k) {
    dx.col(k) = x_[static_cast<std::size_t>(k) + 1] - x_[static_cast<std::size_t>(k)];
    df.col(k) = f_[static_cast<std::size_t>(k) + 1] - f_[static_cast<std::size_t>(k)];
  }
  const Eigen::VectorXd weight = df.colPivHouseholderQr().solve(f);
  const Eigen::VectorXd change = -(dx + df) * weight;
  if (!change.allFinite()) return g;
  return g + change.cwiseMax(-longest).cwiseMin(longest);
}

}  // namespace kappamu::inverse
