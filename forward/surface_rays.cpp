#include "forward/surface_rays.h"

#include <limits>

namespace kappamu::forward {

namespace {

/// Of the object's size.
constexpr double off_triangle = 1e-6;

}  // namespace

SurfaceRays::SurfaceRays(const ObjectProblem& problem)
    : problem_(problem), off_(off_triangle * bounding_box(problem.mesh).sizes().maxCoeff()) {}

std::optional<RayHit> SurfaceRays::first_hit(std::size_t t,
                                             const Eigen::Vector3d& direction) const {
  const Surface& surface = problem_.surface;
  const auto hit = problem_.rays.first_hit(surface.position[t], direction, off_);
  if (!hit) return std::nullopt;
  // A wall from its other side is rounding at an edge.
  const double leaves = surface.normal[t].dot(direction);
  const double meets = surface.normal[static_cast<std::size_t>(hit->triangle)].dot(direction);
  return leaves * meets < 0.0 ? hit : std::nullopt;
}

double SurfaceRays::along(std::size_t t, const Eigen::Vector3d& direction) const {
  const auto hit = first_hit(t, direction);
  return hit ? hit->distance : std::numeric_limits<double>::infinity();
}

}  // namespace kappamu::forward
