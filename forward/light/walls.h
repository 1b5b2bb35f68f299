// An object's surface as light meets it: from inside, where it is on its way, and from outside.
#pragma once

#include "forward/object_model.h"

namespace kappamu::forward {

/// Snell's law for a direction that meets a surface against its normal; `eta_ratio` is the index
/// where it comes from over the one where it goes. Beyond the critical angle: along the surface.
Eigen::Vector3d refracted(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                          double eta_ratio);
/// By a mirror of this normal.
Eigen::Vector3d mirrored(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal);

class Walls {
 public:
  /// Refers to the problem's surface and rays.
  explicit Walls(const ObjectProblem& problem);

  double eta() const { return eta_; }
  const Eigen::Vector3d& normal(int triangle) const {
    return surface_.normal[static_cast<std::size_t>(triangle)];
  }
  double nudge() const { return nudge_; }  ///< [mm]
  /// A point of the surface, taken inwards and from the edges of its triangle by a way that rays
  /// tell from none.
  Eigen::Vector3d nudged(const Eigen::Vector3d& position, int triangle) const;
  /// The wall ahead of light inside that stands on a triangle; takes it inwards where rounding took
  /// it out. None: it slips out along an edge.
  std::optional<RayHit> inside(Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                               int triangle) const;
  /// The wall ahead of light that has left by a triangle.
  std::optional<RayHit> outside(const Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                                int triangle) const;

 private:
  std::optional<RayHit> off(const Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                            int triangle) const;

  const Surface& surface_;
  const RayCaster& rays_;
  double eta_;
  double nudge_;
};

}  // namespace kappamu::forward
