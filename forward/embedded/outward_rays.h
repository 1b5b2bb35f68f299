// Rays from the middles of an object's triangles across the outside, to the surface they face.
#pragma once

#include <cstddef>
#include <optional>

#include "forward/object_model.h"

namespace kappamu::forward::embedded {

class OutwardRays {
 public:
  /// Refers to `problem`.
  explicit OutwardRays(const ObjectProblem& problem);
  /// Where a ray from triangle `t` meets the surface from outside.
  std::optional<RayHit> first_hit(std::size_t t, const Eigen::Vector3d& direction) const;

 private:
  const ObjectProblem& problem_;
  double off_;  ///< a ray leaves its triangle by this before it looks for another [mm]
};

}  // namespace kappamu::forward::embedded
