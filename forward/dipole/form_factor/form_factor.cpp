#include "forward/dipole/form_factor/form_factor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "forward/dipole/form_factor/quadrature.h"

namespace kappamu::forward::dipole {

namespace {

constexpr std::array<double, 4> gauss_node{-0.8611363115940526, -0.3399810435848563,
                                           0.3399810435848563, 0.8611363115940526};
constexpr std::array<double, 4> gauss_weight{0.3478548451374538, 0.6521451548625461,
                                             0.6521451548625461, 0.3478548451374538};
/// Panels are at most this long in u.
constexpr double panel_length = 1.5;
/// Polygons smaller than this share of their distance, and of the decay's length, take a rule of
/// points: their edges' integrals cancel.
constexpr double small_share = 0.3;
/// Halvings of an edge after which the Taylor series gives up: the point's foot lies on it.
constexpr int most_halvings = 24;

/// An edge in the polygon's plane as the point's foot sees it ([T] Table 3.2).
struct Edge {
  double R = 0.0;                 ///< distance of its line from the foot [mm]
  double start = 0.0, end = 0.0;  ///< t along it, from the foot's own foot [mm]
  double sign = 1.0;              ///< 1 where it runs counter-clockwise about the foot
};

struct Seen {
  double height = 0.0;  ///< signed, along the normal [mm]
  std::vector<Edge> edges;
};

Eigen::Vector3d normal_of(std::span<const Eigen::Vector3d> polygon) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    sum += (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]);
  }
  return sum.normalized();
}

Seen seen_from(std::span<const Eigen::Vector3d> polygon, const Eigen::Vector3d& point) {
  const Eigen::Vector3d normal = normal_of(polygon);
  Seen seen;
  seen.height = normal.dot(point - polygon[0]);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double length = (b - a).norm();
    if (length == 0.0) continue;
    const Eigen::Vector3d along = (b - a) / length;
    const double start = along.dot(a - point);
    const double side = normal.dot(along.cross(point - a));
    seen.edges.push_back({std::abs(side), start, start + length, side >= 0.0 ? 1.0 : -1.0});
  }
  return seen;
}

/// ∫ [Φ(h) − Φ(s)] dθ of the edge, Φ by `beyond`(s) of the distance s from the point.
template <class Beyond>
double edge_integral(const Edge& edge, double height, double smooth, const Beyond& beyond,
                     int& samples) {
  const double inner = edge.R * edge.R + height * height;
  const double S = std::sqrt(inner + smooth * smooth);
  const double first = std::asinh(edge.start / S), last = std::asinh(edge.end / S);
  const int panels = std::max(1, static_cast<int>(std::ceil((last - first) / panel_length)));
  const double half = 0.5 * (last - first) / panels, at_foot = beyond(height);
  double sum = 0.0;
  for (int p = 0; p < panels; ++p) {
    for (std::size_t g = 0; g < gauss_node.size(); ++g) {
      const double u = first + half * (2 * p + 1 + gauss_node[g]);
      const double t = S * std::sinh(u);
      const double dtheta = edge.R * S * std::cosh(u) / (edge.R * edge.R + t * t);
      sum += gauss_weight[g] * dtheta * (at_foot - beyond(std::sqrt(inner + t * t)));
      ++samples;
    }
  }
  return half * sum;
}

template <class Beyond>
FormFactor edge_sum(const Seen& seen, double height, double smooth, const Beyond& beyond) {
  FormFactor result;
  for (const Edge& edge : seen.edges) {
    if (edge.R == 0.0) continue;
    result.value += edge.sign * edge_integral(edge, height, smooth, beyond, result.samples);
  }
  return result;
}

/// ∫ Φ dθ by [T] 3.19.
double taylor_integral(const Profile& profile, const Edge& edge, double height, double ratio,
                       int halvings, int& samples) {
  const double length = edge.end - edge.start, middle = 0.5 * (edge.start + edge.end);
  const double r2 = edge.R * edge.R + middle * middle;
  if (halvings < most_halvings &&
      (length * length > ratio * ratio * r2 || length * profile.decay() > ratio)) {
    Edge left = edge, right = edge;
    left.end = right.start = middle;
    return taylor_integral(profile, left, height, ratio, halvings + 1, samples) +
           taylor_integral(profile, right, height, ratio, halvings + 1, samples);
  }
  ++samples;
  return profile.beyond(std::sqrt(r2 + height * height)) * edge.R * length / r2;
}

}  // namespace

FormFactor form_factor(const Profile& profile, std::span<const Eigen::Vector3d> polygon,
                       const Eigen::Vector3d& point) {
  check(polygon.size() >= 3, "a form factor needs a polygon");
  double extent = 0.0;
  for (const Eigen::Vector3d& v : polygon) extent = std::max(extent, (v - polygon[0]).norm());
  const double distance = std::hypot((point - polygon[0]).norm(), profile.smallest_depth());
  if (extent <= small_share * distance && extent * profile.decay() <= small_share) {
    FormFactor result;
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      result.value += triangle_rule(
          {polygon[0], polygon[i - 1], polygon[i]},
          [&](const Eigen::Vector3d& x) { return profile.value((x - point).norm()); });
      result.samples += rule_points;
    }
    return result;
  }
  const Seen seen = seen_from(polygon, point);
  return edge_sum(seen, seen.height, profile.smallest_depth(),
                  [&](double s) { return profile.beyond(s); });
}

FormFactor taylor_form_factor(const Profile& profile, std::span<const Eigen::Vector3d> polygon,
                              const Eigen::Vector3d& point, double ratio) {
  const Seen seen = seen_from(polygon, point);
  FormFactor result;
  double angle = 0.0;
  for (const Edge& edge : seen.edges) {
    if (edge.R == 0.0) continue;
    angle += edge.sign * (std::atan(edge.end / edge.R) - std::atan(edge.start / edge.R));
    result.value -=
        edge.sign * taylor_integral(profile, edge, seen.height, ratio, 0, result.samples);
  }
  // The first terms of [T] 3.12: 2π where the foot lies inside the polygon, 0 outside.
  const double turns = std::round(angle / (2.0 * std::numbers::pi));
  result.value += 2.0 * std::numbers::pi * turns * profile.beyond(seen.height);
  return result;
}

FormFactor aligned_form_factor(const Profile& profile, std::span<const Eigen::Vector3d> polygon,
                               const Eigen::Vector3d& point) {
  const Seen seen = seen_from(polygon, point);
  FormFactor result;
  for (const SourceTerm& term : profile.terms()) {
    // The foot's distance to the source's plane takes the point's height; z is in the term alone.
    const double height = std::abs(seen.height + term.side * term.z);
    const FormFactor part =
        edge_sum(seen, height, 0.0, [&](double s) { return profile.term_beyond(term, s); });
    result.value += part.value;
    result.samples += part.samples;
  }
  return result;
}

}  // namespace kappamu::forward::dipole
