#include "forward/dipole/direct/direct_sum.h"

#include <array>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/dipole/form_factor/form_factor.h"

namespace kappamu::forward::dipole {

namespace {

/// Distance over √area within which a triangle is integrated.
constexpr double near_sizes = 12.0;

}  // namespace

std::vector<double> direct_sum(const TriangleMesh& mesh, const Surface& surface,
                               const Profile& profile, Placement placement,
                               std::span<const double> irradiance,
                               std::span<const std::size_t> receivers) {
  check(irradiance.size() == surface.size(), "one irradiance per triangle");
  std::vector<double> exitance(receivers.size());
  for_rows(static_cast<int>(receivers.size()), [&](int row) {
    const auto o = static_cast<std::size_t>(row);
    const Eigen::Vector3d& to = surface.position[receivers[o]];
    double sum = 0.0;
    for (std::size_t i = 0; i < surface.size(); ++i) {
      if (irradiance[i] == 0.0) continue;
      const Eigen::Vector3d& from = surface.position[i];
      const double r2 = (to - from).squaredNorm();
      const bool aligned = placement == Placement::aligned;
      double factor = 0.0;
      if (r2 < near_sizes * near_sizes * surface.area[i]) {
        std::array<Eigen::Vector3d, 3> corners;
        for (std::size_t c = 0; c < 3; ++c) {
          corners[c] = mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][c])];
        }
        factor = (aligned ? aligned_form_factor(profile, corners, to)
                          : form_factor(profile, corners, to))
                     .value;
      } else {
        factor = surface.area[i] * (aligned ? profile.aligned_value(from, surface.normal[i], to)
                                            : profile.value(std::sqrt(r2)));
      }
      sum += irradiance[i] * factor;
    }
    exitance[o] = sum;
  });
  return exitance;
}

}  // namespace kappamu::forward::dipole
