// The inverse response between knots, as recovery from exposure stacks fits it; see response.h for
// the model.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace kappamu::capture {

struct CurveObservation {
  int knot = 0;         ///< between knot and knot + 1
  double weight_1 = 0;  ///< share of knot + 1
  double base = 0;      ///< ln((z - black)/(top - black))
  double log_exposure = 0;
  double code = 0;
  double code_variance = 0;   ///< of the block's mean
  double total_variance = 0;  ///< the same with log_exposure_floor, as a variance of the code
  double robust = 1;          ///< 1 for an inlier, 0 for an outlier
  double weight = 0;          ///< of ln exposure in the least squares
};

class ResponseCurve {
 public:
  ResponseCurve(double black_level, int bit_depth, int knots, double highest_code);

  int knots() const { return static_cast<int>(s_.size()); }
  Eigen::VectorXd& s() { return s_; }
  double range() const { return range_; }
  double black() const { return black_; }
  double slope_at_black() const { return std::exp(s_[0]) / range_; }

  /// The place of a code above black among the knots.
  void locate(double code, CurveObservation& observation) const;
  double g(const CurveObservation& at) const {
    return at.base + s_[at.knot] * (1.0 - at.weight_1) + s_[at.knot + 1] * at.weight_1;
  }
  /// dg/dz
  double slope(const CurveObservation& at) const;
  double linear(double code) const;

 private:
  /// v of a code above black.
  double place(double z) const;

  double black_;
  double range_;
  double toe_;
  double end_;
  double step_;
  Eigen::VectorXd s_;
};

/// Pools adjacent violators, then keeps the smallest slope that leaves the table invertible.
/// Returns the number of codes changed.
int make_rising(std::vector<double>& linear);

}  // namespace kappamu::capture
