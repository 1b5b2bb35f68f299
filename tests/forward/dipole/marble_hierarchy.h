// Marble in sunlight, what its hierarchy errs by, and shapes that move.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/random.h"
#include "forward/dipole/direct/direct_sum.h"
#include "forward/dipole/hierarchy/hierarchy.h"

namespace kappamu::forward::dipole {

constexpr double promised = 0.01;

inline device::Context& context() {
  return device::Context::chosen("auto");
}

/// Jensen et al. 2001 at η = 1.3, red, green, blue.
inline std::vector<Profile> marble(double scale = 1.0, const char* name = "dipole") {
  std::vector<Profile> profiles;
  for (const auto& [scattering, absorption] :
       {std::pair{2.19, 0.0021}, std::pair{2.62, 0.0041}, std::pair{3.00, 0.0071}}) {
    profiles.push_back(
        make_profile(name, {scale / (3.0 * (scattering + absorption)), absorption / scale}, 1.3));
  }
  return profiles;
}

/// Light from (1, 1, 1), of another strength in each lane.
inline std::vector<Eigen::Array4f> sunlight(const Surface& surface) {
  const Eigen::Vector3d sun = Eigen::Vector3d(1, 1, 1).normalized();
  std::vector<Eigen::Array4f> light;
  for (const Eigen::Vector3d& normal : surface.normal) {
    const auto e = static_cast<float>(std::max(0.0, normal.dot(sun)));
    light.emplace_back(e, 0.7F * e, 0.2F * e, 0.0F);
  }
  return light;
}

/// Relative 2-norm of the hierarchy's error on the surface, of the worst lane, at every `stride`th
/// triangle.
inline double error_of(const std::vector<Eigen::Array4f>& exitance, const TriangleMesh& mesh,
                       const std::vector<Profile>& profiles, std::size_t stride) {
  const Surface surface = surface_of(mesh);
  const std::vector<Eigen::Array4f> light = sunlight(surface);
  std::vector<std::size_t> receivers;
  for (std::size_t t = stride / 2; t < surface.size(); t += stride) receivers.push_back(t);
  double worst = 0.0;
  for (std::size_t lane = 0; lane < profiles.size(); ++lane) {
    const auto l = static_cast<Eigen::Index>(lane);
    std::vector<double> irradiance;
    for (const Eigen::Array4f& e : light) irradiance.push_back(static_cast<double>(e[l]));
    const std::vector<double> exact =
        direct_sum(mesh, surface, profiles[lane], Placement::rotated, irradiance, receivers);
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < receivers.size(); ++i) {
      const double area = surface.area[receivers[i]];
      const double found = static_cast<double>(exitance[receivers[i]][l]);
      difference += area * (found - exact[i]) * (found - exact[i]);
      size += area * exact[i] * exact[i];
    }
    worst = std::max(worst, std::sqrt(difference / size));
  }
  return worst;
}

/// Waves of other lengths, directions and phases for every seed.
inline TriangleMesh waved(TriangleMesh mesh, double height, std::uint64_t seed) {
  const auto draw = [&](std::uint64_t i) { return 2.0 * uniform(key_of({seed, i})) - 1.0; };
  const Eigen::Vector3d along(0.4 * draw(1), 0.4 * draw(2), 0.4 * draw(3)),
      by(draw(4), draw(5), draw(6));
  for (Eigen::Vector3d& v : mesh.vertices) {
    v += height * std::sin(along.dot(v) + 3.0 * draw(7)) * by;
  }
  return mesh;
}

}  // namespace kappamu::forward::dipole
