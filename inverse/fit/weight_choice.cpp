#include "inverse/fit/weight_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"

namespace kappamu::inverse {

namespace {

using Point = std::array<double, 2>;

/// Curvature of the circle through three points, positive where the way from a to c turns left.
double menger_curvature(const Point& a, const Point& b, const Point& c) {
  const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  const auto distance = [](const Point& p, const Point& q) {
    return std::hypot(p[0] - q[0], p[1] - q[1]);
  };
  const double sides = distance(a, b) * distance(b, c) * distance(c, a);
  return sides > 0.0 ? 2.0 * area / sides : 0.0;
}

WeightDecision corner(std::span<const PathPoint> path) {
  std::vector<Point> curve;
  for (const PathPoint& p : path) {
    const double tiny = std::numeric_limits<double>::min();
    curve.push_back({std::log(std::max(p.chi2, tiny)), std::log(std::max(p.roughness, tiny))});
  }
  // From strong to weak weights χ² falls and R rises: at the corner the way turns right, upwards.
  WeightDecision decision{path.size() - 1, false};
  double sharpest = 0.0;
  for (std::size_t i = 1; i + 1 < curve.size(); ++i) {
    const double bend = -menger_curvature(curve[i - 1], curve[i], curve[i + 1]);
    if (bend <= sharpest) continue;
    sharpest = bend;
    decision.chosen = i;
  }
  constexpr std::size_t beyond = 3;  // two of them bend less
  decision.done = sharpest > 0.0 && decision.chosen + beyond < path.size();
  return decision;
}

WeightDecision least_held_out(std::span<const PathPoint> path, double least_relief) {
  WeightDecision decision;
  for (std::size_t i = 0; i < path.size(); ++i) {
    check(path[i].held_out_chi2.has_value(), "the rule needs patterns held out");
    if (*path[i].held_out_chi2 < *path[decision.chosen].held_out_chi2) decision.chosen = i;
  }
  if (path.size() < 2) return decision;
  const double before = *path[path.size() - 2].held_out_chi2;
  decision.done = *path.back().held_out_chi2 > (1.0 - least_relief) * before;
  return decision;
}

}  // namespace

std::string to_string(WeightRule rule) {
  switch (rule) {
    case WeightRule::l_curve:
      return "l-curve";
    case WeightRule::held_out:
      return "held-out";
    default:
      return "discrepancy";
  }
}

WeightDecision choose_weight(WeightRule rule, std::span<const PathPoint> path,
                             double least_relief) {
  check(!path.empty() && rule != WeightRule::discrepancy, "no path to choose from");
  return rule == WeightRule::l_curve ? corner(path) : least_held_out(path, least_relief);
}

}  // namespace kappamu::inverse
