// Form factors by adaptive quadrature: the independent, slow reference.
#pragma once

#include <cmath>

#include "forward/dipole/form_factor/triangle_rule.h"
#include "forward/dipole/profile/profile.h"

namespace kappamu::forward::dipole {

/// By the rule, the triangle split in four until it agrees with its quarters to `tolerance`,
/// relative, or as often as is sensible.
template <class F>
double integral(const Corners& t, const F& f, double tolerance, int splits = 14) {
  const Eigen::Vector3d m0 = 0.5 * (t[1] + t[2]), m1 = 0.5 * (t[0] + t[2]),
                        m2 = 0.5 * (t[0] + t[1]);
  const std::array<Corners, 4> quarters{Corners{t[0], m2, m1}, Corners{t[1], m0, m2},
                                        Corners{t[2], m1, m0}, Corners{m0, m1, m2}};
  double fine = 0.0;
  for (const Corners& q : quarters) fine += triangle_rule(q, f);
  if (splits == 0 || std::abs(fine - triangle_rule(t, f)) <= tolerance * std::abs(fine)) {
    return fine;
  }
  fine = 0.0;
  for (const Corners& q : quarters) fine += integral(q, f, tolerance, splits - 1);
  return fine;
}

/// The sources rotated ([T] 3.4), or along the triangle's normal.
inline double quadrature_form_factor(const Profile& profile, const Corners& triangle,
                                     const Eigen::Vector3d& point, double tolerance = 1e-6) {
  return integral(
      triangle, [&](const Eigen::Vector3d& x) { return profile.value((x - point).norm()); },
      tolerance);
}

inline double quadrature_aligned_form_factor(const Profile& profile, const Corners& triangle,
                                             const Eigen::Vector3d& point,
                                             double tolerance = 1e-6) {
  const Eigen::Vector3d normal =
      (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
  return integral(
      triangle, [&](const Eigen::Vector3d& x) { return profile.aligned_value(x, normal, point); },
      tolerance);
}

}  // namespace kappamu::forward::dipole
