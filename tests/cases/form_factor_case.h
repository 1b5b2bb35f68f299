// A random sweep of triangles, points and media for form factors of the dipole: sizes of a tenth to
// thirty mean free paths, any shape, points in the plane, on an edge, or up to ten mean free paths
// off it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "forward/dipole/profile/profile.h"

namespace kappamu::test_cases {

struct FormFactorCase {
  forward::Material material;
  std::array<Eigen::Vector3d, 3> triangle;  ///< [mm]
  Eigen::Vector3d point;                    ///< [mm]
  bool on_edge = false;
};

/// Case `number` of population `seed`.
FormFactorCase form_factor_case(std::uint64_t seed, std::uint64_t number);

}  // namespace kappamu::test_cases
