// R_d over a triangle by points, for triangles that are small as seen from the point.
#pragma once

#include <Eigen/Geometry>
#include <array>

namespace kappamu::forward::dipole {

using Corners = std::array<Eigen::Vector3d, 3>;  ///< of a triangle [mm]

inline constexpr int rule_points = 7;

/// ∫ f over the triangle, seven points of degree 5 (Radon 1948).
template <class F>
double triangle_rule(const Corners& t, const F& f) {
  constexpr double a = 0.470142064105115, b = 0.101286507323456;
  const auto at = [&](double x, double y) {
    return f(Eigen::Vector3d(t[0] * (1.0 - x - y) + t[1] * x + t[2] * y));
  };
  const double area = 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
  return area * (0.225 * at(1.0 / 3.0, 1.0 / 3.0) +
                 0.132394152788506 * (at(a, a) + at(1 - 2 * a, a) + at(a, 1 - 2 * a)) +
                 0.125939180544827 * (at(b, b) + at(1 - 2 * b, b) + at(b, 1 - 2 * b)));
}

}  // namespace kappamu::forward::dipole
