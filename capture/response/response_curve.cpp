#include "capture/response/response_curve.h"

#include <algorithm>

namespace kappamu::capture {
namespace {

// Scale of the toe in v = ln(1 + (z - black)/toe) + shoulder term, as a share of the code range:
// below it the curve is taken to be nearly straight, above it nearly a power law. Between 2 % and
// 10 % the recovered curves of the tests differ by less than 0.1 % (median over codes).
constexpr double toe_share = 0.05;
// The shoulder term, -shoulder_weight ln(1 - (z - black)/((1 + shoulder) range)), stretches v
// towards the largest code. A curve that flattens there bends ever faster; without the term the
// smoothness that suits the rest cut that bend, and the curve's end, which sets its common factor,
// was 0.5 to 1.1 % off (film_curve in the tests). More of it (0.2 to 0.5) lets the extrapolation
// from the last samples wander: 0.5 to 0.8 % on curves without such a bend. So it would with
// samples that end early: the shoulder is a few times the gap they leave.
constexpr double least_shoulder = 0.05;
constexpr double shoulder_over_gap = 3.0;
constexpr double shoulder_weight = 0.1;

}  // namespace

ResponseCurve::ResponseCurve(double black_level, int bit_depth, int knots, double highest_code)
    : black_(black_level),
      range_((1 << bit_depth) - 1 - black_level),
      toe_(toe_share * range_),
      end_(range_ + std::max(least_shoulder * range_,
                             shoulder_over_gap * (black_level + range_ - highest_code))),
      step_(place(range_) / (knots - 1)),
      s_(Eigen::VectorXd::Zero(knots)) {}

void ResponseCurve::locate(double code, CurveObservation& observation) const {
  const double at = place(code - black_) / step_;
  observation.knot = std::clamp(static_cast<int>(at), 0, knots() - 2);
  observation.weight_1 = at - observation.knot;
  observation.base = std::log((code - black_) / range_);
}

double ResponseCurve::slope(const CurveObservation& at) const {
  const double z = at.code - black_;
  const double dv = 1.0 / (toe_ + z) + shoulder_weight / (end_ - z);
  return 1.0 / (at.code - black_) + (s_[at.knot + 1] - s_[at.knot]) / step_ * dv;
}

double ResponseCurve::linear(double code) const {
  if (code <= black_) return slope_at_black() * (code - black_);
  CurveObservation at;
  locate(code, at);
  return std::exp(g(at));
}

double ResponseCurve::place(double z) const {
  return std::log1p(z / toe_) - shoulder_weight * std::log1p(-z / end_);
}

int make_rising(std::vector<double>& linear) {
  struct Pool {
    double sum;
    int count;
  };
  std::vector<Pool> pools;
  for (const double value : linear) {
    pools.push_back({value, 1});
    while (pools.size() > 1) {
      const Pool last = pools.back();
      const Pool before = pools[pools.size() - 2];
      if (before.sum / before.count < last.sum / last.count) break;
      pools.pop_back();
      pools.back() = {before.sum + last.sum, before.count + last.count};
    }
  }
  int changed = 0;
  std::size_t at = 0;
  for (const Pool& pool : pools) {
    if (pool.count > 1) changed += pool.count;
    for (int i = 0; i < pool.count; ++i) linear[at++] = pool.sum / pool.count;
  }
  const double least_step = 1e-9;
  for (std::size_t code = 1; code < linear.size(); ++code) {
    linear[code] = std::max(linear[code], linear[code - 1] + least_step);
  }
  return changed;
}

}  // namespace kappamu::capture
