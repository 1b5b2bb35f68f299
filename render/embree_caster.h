// Rays against a triangle mesh by Embree 3 (Wald et al. 2014), to double precision.
//
// Embree finds candidates in single precision, in a frame where the mesh's box spans [-1, 1]; each
// is then intersected in double precision, in mm. Rays start 1e-5 of that before `nearest`, so
// that no near surface is lost to rounding, and what double precision puts at or before `nearest`
// is left out. So:
//  - a ray that starts on a triangle may have `nearest` = 0. Rounding may report that triangle
//    again, at some 1e-16 of the box over the cosine: a caller who knows the triangle ignores it,
//    since a ray meets a plane once;
//  - one that starts within 1e-5 of the box of an edge and leaves by it at a grazing angle may slip
//    past the neighbour (1 in 10^5 of random rays): a caller who knows to be inside and hears of no
//    hit, or of one from outside, steps 1e-6 of the box inwards and asks again;
//  - a ray through an edge or a vertex meets one of the triangles there (Embree's robust mode);
//    weights lie in the triangle;
//  - of surfaces closer to each other than 1e-7 of the box, either may be reported first.
#pragma once

#include <memory>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "core/ray_caster.h"

namespace kappamu::render {

/// One whose mesh may move. The first move builds a structure that later moves refit: they take a
/// few nanoseconds a triangle, and rays get slower the farther the mesh is from that first move.
class MovableCaster : public RayCaster {
 public:
  /// As many vertices as before, of the same triangles. No ray may be under way.
  virtual void move(const std::vector<Eigen::Vector3d>& vertices) = 0;
  /// Into `hits`, in order, all that the ray meets at a distance in (`nearest`, `farthest`), by one
  /// walk through the mesh. An edge may count once for each of its triangles.
  virtual void all_hits(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                        double nearest, double farthest, std::vector<RayHit>& hits) const = 0;
};

/// Keeps a copy of the mesh. Triangles without area are never met. Throws InputError where memory
/// does not suffice.
std::unique_ptr<MovableCaster> make_embree_caster(const TriangleMesh& mesh);

}  // namespace kappamu::render
