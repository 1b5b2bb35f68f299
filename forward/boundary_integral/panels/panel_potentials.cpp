#include "forward/boundary_integral/panels/panel_potentials.h"

#include <cmath>
#include <numbers>

namespace kappamu::forward::boundary_integral {

namespace {

/// Gauss points on [−1, 1], the positive half.
constexpr std::array<double, 4> node{0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                     0.9602898564975363};
constexpr std::array<double, 4> weight{0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                       0.1012285362903763};

/// u(R) = (1 − e^−λR)/λ − R and v(R) = (e^−λR − 1)/R, or what λ adds along an edge:
/// ∫ [u(R) − u(|d|)] dθ and ∫ [v(|d|) − v(R)] dθ.
struct Added {
  double u = 0.0, v = 0.0;
};

Added added_at(double decay, double r) {
  const double z = decay * r;
  if (z < 1e-3) {
    return {-r * z * (0.5 - z / 6.0 * (1.0 - z / 4.0)), -decay * (1.0 - z / 2.0 * (1.0 - z / 3.0))};
  }
  const double fall = std::expm1(-z);
  return {-fall / decay - r, fall / r};
}

/// From t = P sinh(from) to P sinh(to), at most as long as the rule resolves.
void add_piece(double decay, double p, double height, double from, double to, const Added& foot,
               Added& added) {
  const double half = 0.5 * (to - from), middle = 0.5 * (to + from);
  for (std::size_t g = 0; g < 2 * node.size(); ++g) {
    const std::size_t k = g % node.size();
    const double s = middle + (g < node.size() ? half : -half) * node[k];
    const double e = std::exp(s), cosh = 0.5 * (e + 1.0 / e);
    const Added here = added_at(decay, std::sqrt(height * height + p * p * cosh * cosh));
    const double w = half * weight[k] / cosh;
    added.u += w * (here.u - foot.u);
    added.v += w * (foot.v - here.v);
  }
}

Added added_along(double decay, double p, double height, double t0, double t1) {
  constexpr double longest_piece = 3.0;
  const Added foot = added_at(decay, height);
  const double from = std::asinh(t0 / p), to = std::asinh(t1 / p);
  const int pieces = 1 + static_cast<int>((to - from) / longest_piece);
  Added added;
  for (int k = 0; k < pieces; ++k) {
    add_piece(decay, p, height, from + (to - from) * k / pieces,
              from + (to - from) * (k + 1) / pieces, foot, added);
  }
  return added;
}

}  // namespace

PanelPotentials panel_potentials(const Panel& panel, const Eigen::Vector3d& x, double decay) {
  /// Nearer to an edge's line, of the panel's radius, the edge adds nothing.
  constexpr double on_line = 1e-12;
  const double d = (x - panel.centre).dot(panel.normal), height = std::abs(d);
  double laplace = 0.0, turn = 0.0;
  Added added;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d a = panel.corner[k] - x, b = panel.corner[(k + 1) % 3] - x;
    const double length = (b - a).norm();
    const Eigen::Vector3d along = (b - a) / length;
    const double p = a.dot(along.cross(panel.normal));
    if (std::abs(p) <= on_line * panel.radius) continue;
    const double t0 = a.dot(along), t1 = b.dot(along), r0 = a.norm(), r1 = b.norm();
    const double square = p * p + d * d;
    laplace += p * std::log((r0 + r1 + length) / (r0 + r1 - length));
    turn += std::atan2(p * t1, square + height * r1) - std::atan2(p * t0, square + height * r0);
    if (decay > 0.0) {
      const Added edge = added_along(decay, std::abs(p), height, t0, t1);
      added.u += std::copysign(1.0, p) * edge.u;
      added.v += std::copysign(1.0, p) * edge.v;
    }
  }
  constexpr double four_pi = 4.0 * std::numbers::pi;
  const double side = height <= on_line * panel.radius ? 0.0 : std::copysign(1.0, d);
  return {(laplace - height * turn + added.u) / four_pi, (side * turn + d * added.v) / four_pi};
}

}  // namespace kappamu::forward::boundary_integral
