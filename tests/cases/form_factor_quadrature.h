// R_d over a triangle by points, split adaptively: the independent, slow reference of form factors.
#pragma once

#include "forward/dipole/form_factor/quadrature.h"
#include "forward/dipole/profile/profile.h"

namespace kappamu::test_cases {

/// The rule, the triangle split in four until it agrees with its quarters to `tolerance`, relative.
/// The sources rotated ([T] 3.4), or along the triangle's normal.
double quadrature_form_factor(const forward::dipole::Profile& profile,
                              const forward::dipole::Corners& triangle,
                              const Eigen::Vector3d& point, double tolerance = 1e-6);
double quadrature_aligned_form_factor(const forward::dipole::Profile& profile,
                                      const forward::dipole::Corners& triangle,
                                      const Eigen::Vector3d& point, double tolerance = 1e-6);

}  // namespace kappamu::test_cases
