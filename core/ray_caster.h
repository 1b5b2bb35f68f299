// Rays against an object's surface. Forward models ask through this interface, so that they build
// without the library that answers (render/embree_caster.h).
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>

namespace kappamu {

struct RayHit {
  double distance = 0.0;  ///< [mm], in units of the direction's length
  int triangle = 0;
  double u = 0.0, v = 0.0;  ///< barycentric weights of the triangle's second and third vertex
};

/// Safe for use from several threads at once.
class RayCaster {
 public:
  virtual ~RayCaster() = default;
  /// The first surface that the ray meets at a distance in (`nearest`, `farthest`), from either
  /// side.
  virtual std::optional<RayHit> first_hit(
      const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double nearest = 0.0,
      double farthest = std::numeric_limits<double>::infinity()) const = 0;
  /// Whether there is one.
  virtual bool any_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                       double nearest, double farthest) const {
    return first_hit(origin, direction, nearest, farthest).has_value();
  }
};

}  // namespace kappamu
