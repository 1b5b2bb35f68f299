// Rays from the middles of an object's triangles to the surface they face: across the outside, or
// through the object.
#pragma once

#include <cstddef>
#include <optional>

#include "forward/object_model.h"

namespace kappamu::forward {

class SurfaceRays {
 public:
  /// Refers to `problem`.
  explicit SurfaceRays(const ObjectProblem& problem);
  /// Where a ray from triangle `t` crosses the surface again, from the side that it set out on.
  std::optional<RayHit> first_hit(std::size_t t, const Eigen::Vector3d& direction) const;
  /// How far the surface lies in front of triangle `t`, and behind it: a slit's width and a part's
  /// thickness [mm]. Infinite where a ray along the normal meets nothing.
  double gap(std::size_t t) const { return along(t, problem_.surface.normal[t]); }
  double thickness(std::size_t t) const { return along(t, -problem_.surface.normal[t]); }

 private:
  double along(std::size_t t, const Eigen::Vector3d& direction) const;

  const ObjectProblem& problem_;
  double off_;  ///< a ray leaves its triangle by this before it looks for another [mm]
};

}  // namespace kappamu::forward
