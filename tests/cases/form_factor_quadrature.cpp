#include "tests/cases/form_factor_quadrature.h"

#include <cmath>

namespace kappamu::test_cases {

using forward::dipole::Corners;
using forward::dipole::Profile;
using forward::dipole::triangle_rule;

namespace {

/// Splits of a triangle after which the rule is taken as it is.
constexpr int most_splits = 14;

template <class F>
double integral(const Corners& t, const F& f, double tolerance, int splits) {
  const Eigen::Vector3d m0 = 0.5 * (t[1] + t[2]), m1 = 0.5 * (t[0] + t[2]),
                        m2 = 0.5 * (t[0] + t[1]);
  const std::array<Corners, 4> quarters{Corners{t[0], m2, m1}, Corners{t[1], m0, m2},
                                        Corners{t[2], m1, m0}, Corners{m0, m1, m2}};
  double fine = 0.0;
  for (const Corners& q : quarters) fine += triangle_rule(q, f);
  if (splits == most_splits || std::abs(fine - triangle_rule(t, f)) <= tolerance * std::abs(fine)) {
    return fine;
  }
  fine = 0.0;
  for (const Corners& q : quarters) fine += integral(q, f, tolerance, splits + 1);
  return fine;
}

}  // namespace

double quadrature_form_factor(const Profile& profile, const Corners& triangle,
                              const Eigen::Vector3d& point, double tolerance) {
  return integral(
      triangle, [&](const Eigen::Vector3d& x) { return profile.value((x - point).norm()); },
      tolerance, 0);
}

double quadrature_aligned_form_factor(const Profile& profile, const Corners& triangle,
                                      const Eigen::Vector3d& point, double tolerance) {
  const Eigen::Vector3d normal =
      (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
  return integral(
      triangle, [&](const Eigen::Vector3d& x) { return profile.aligned_value(x, normal, point); },
      tolerance, 0);
}

}  // namespace kappamu::test_cases
