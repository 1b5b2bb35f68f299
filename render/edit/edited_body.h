// The object in which an edited volume lies, as selections of its frame see it: where the voxels
// are, how deep below its surface, and what of the surface is seen from a place.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "core/object_medium.h"
#include "core/ray_caster.h"

namespace kappamu::forward {
class ClosestPoint;
}

namespace kappamu::render {

class EditedBody {
 public:
  /// Of the object's mesh in its own frame [mm], and rays against it; both outlive this.
  /// `object_from_volume` places a volume of `volume_mm` [mm]; `wrap` is what it is beyond its box.
  EditedBody(const TriangleMesh& mesh, const RayCaster& rays,
             const Eigen::Affine3d& object_from_volume, const Eigen::Vector3d& volume_mm,
             Wrap wrap);
  ~EditedBody();

  const Eigen::Affine3d& object_from_volume() const { return object_from_volume_; }
  /// Where the volume lies in the object, again and again where it is repeated or mirrored: one map
  /// for each time that its box meets the object's. Throws InputError where these are too many.
  std::vector<Eigen::Affine3d> images() const;
  /// A place of the object in the volume's own box, where the volume is repeated or mirrored;
  /// nothing beyond a volume that is neither.
  std::optional<Eigen::Vector3d> in_volume(const Eigen::Vector3d& in_object) const;

  struct Below {
    double depth = 0.0;       ///< below the surface, negative outside [mm]
    Eigen::Vector3d surface;  ///< the nearest place of the surface
    Eigen::Vector3d normal;   ///< outward, there
    int triangle = 0;         ///< that holds it
    Eigen::Vector3d weights;  ///< barycentric, of the triangle's corners
  };
  Below below(const Eigen::Vector3d& point) const;
  bool has_texture() const { return !mesh_.texture.empty(); }
  /// The mesh's texture coordinates u, v at a place of its surface.
  Eigen::Vector2d texture_at(const Below& place) const;
  /// Whether nothing of the object hides a place of its surface from `eye`.
  bool sees(const Eigen::Vector3d& eye, const Below& place) const;

 private:
  const TriangleMesh& mesh_;
  const RayCaster& rays_;
  Eigen::Affine3d object_from_volume_;
  Eigen::Vector3d volume_mm_;
  Wrap wrap_;
  double skin_ = 0.0;  ///< distances below this are rounding [mm]
  mutable std::once_flag asked_;
  mutable std::unique_ptr<forward::ClosestPoint> closest_;  ///< made when first asked for
};

}  // namespace kappamu::render
