#include "forward/embedded/outward_rays.h"

namespace kappamu::forward::embedded {

namespace {

/// Of the object's size.
constexpr double off_surface = 1e-6;

}  // namespace

OutwardRays::OutwardRays(const ObjectProblem& problem)
    : problem_(problem), off_(off_surface * bounding_box(problem.mesh).sizes().maxCoeff()) {}

std::optional<RayHit> OutwardRays::first_hit(std::size_t t,
                                             const Eigen::Vector3d& direction) const {
  const Surface& surface = problem_.surface;
  const auto hit = problem_.rays.first_hit(surface.position[t], direction, off_);
  // A wall from inside is rounding at an edge.
  if (hit && surface.normal[static_cast<std::size_t>(hit->triangle)].dot(direction) >= 0.0) {
    return std::nullopt;
  }
  return hit;
}

}  // namespace kappamu::forward::embedded
