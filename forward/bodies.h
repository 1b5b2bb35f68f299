// A mesh of several components as separate bodies: shells that bound one connected piece of
// material, its voids included. Light that leaves a body is not followed, so that each is a problem
// of its own, and no cube joins two of them across a gap.
#pragma once

#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "core/ray_caster.h"
#include "forward/object_model.h"

namespace kappamu::forward {

struct Body {
  TriangleMesh mesh;
  std::vector<int> triangle;  ///< of the whole mesh, per triangle
};

std::vector<Body> bodies(const TriangleMesh& mesh, const RayCaster& rays);

/// The body's own lights. `local` gives per triangle of the whole mesh the body's, −1 where it is
/// another's.
std::vector<ObjectLight> lights_of(const Body& body, const std::vector<int>& local,
                                   const std::vector<ObjectLight>& lights);

/// Rays that see one body only.
class BodyRays : public RayCaster {
 public:
  /// `local` as for lights_of().
  BodyRays(const RayCaster& all, std::vector<int> local) : all_(all), local_(std::move(local)) {}
  std::optional<RayHit> first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                  double nearest, double farthest) const override;

 private:
  const RayCaster& all_;
  std::vector<int> local_;
};

}  // namespace kappamu::forward
