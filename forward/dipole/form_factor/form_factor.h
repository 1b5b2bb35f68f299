// Form factors: R_d integrated over a planar polygon as seen from a point, [T] 3.10. In polar
// coordinates about the point's foot on the plane the integral over the radius is closed, and one
// integral along each edge remains ([T] 3.12 to 3.15), here in general:
//
//   ∫_A R_d dA = Σ_edges ∫ [Φ(h) − Φ(s(θ))] dθ,   Φ(s) = ∫_s^∞ R_d(s') s' ds' = Profile::beyond.
//
// Polygons are closed, planar, and seen from any side; the result is not negative. Lengths in mm.
#pragma once

#include <Eigen/Core>
#include <span>

#include "forward/dipole/profile/profile.h"

namespace kappamu::forward::dipole {

struct FormFactor {
  double value = 0.0;  ///< dimensionless
  int samples = 0;     ///< evaluations of Φ or R_d, the cost
};

/// Each edge by Gauss-Legendre panels in u = asinh(t/S), t along the edge from the foot's foot and
/// S² = distance of its line² + z², z the profile's smallest depth: the integrand varies over no
/// shorter length, wherever the point lies. Polygons small as seen from the point take seven points
/// a triangle. Relative error below 1e-3 (docs/dipole.md).
FormFactor form_factor(const Profile& profile, std::span<const Eigen::Vector3d> polygon,
                       const Eigen::Vector3d& point);

/// [T] 3.19 and 3.21: the lowest order of the Taylor series about the middle of each edge, edges
/// halved until length / distance <= `ratio` and length · σ <= `ratio`. [T]: ratio = 2/5.
FormFactor taylor_form_factor(const Profile& profile, std::span<const Eigen::Vector3d> polygon,
                              const Eigen::Vector3d& point, double ratio = 0.4);

/// With the sources along the polygon's normal (counter-clockwise seen from outside): they lie in
/// planes parallel to it, and the same edge integrals hold in each.
FormFactor aligned_form_factor(const Profile& profile, std::span<const Eigen::Vector3d> polygon,
                               const Eigen::Vector3d& point);

}  // namespace kappamu::forward::dipole
