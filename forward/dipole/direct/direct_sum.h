// The dipole's surface integral summed over every triangle: what the hierarchy is measured against,
// and the only evaluation of sources along the normal. Cost is receivers × triangles.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "forward/dipole/profile/profile.h"

namespace kappamu::forward::dipole {

/// Where the sources of light that entered at x_i lie ([T] Fig. 3.2).
enum class Placement {
  rotated,  ///< perpendicular to x_o − x_i: reciprocal
  aligned   ///< along the normal at x_i
};

/// Exitance at the centroids of `receivers` from the transmitted irradiance on each triangle;
/// form factors within twelve triangle sizes, the centroid's value beyond (error below 0.3 %).
/// Equal bits on any number of cores.
std::vector<double> direct_sum(const TriangleMesh& mesh, const Surface& surface,
                               const Profile& profile, Placement placement,
                               std::span<const double> irradiance,
                               std::span<const std::size_t> receivers);

}  // namespace kappamu::forward::dipole
