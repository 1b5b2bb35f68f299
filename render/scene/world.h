// A scene made ready: its objects as meshes with media, and one caster for rays through all of
// them.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/polycube.h"
#include "core/mesh/triangle_mesh.h"
#include "core/optics.h"
#include "core/rigid.h"
#include "render/embree_caster.h"
#include "render/scene/object_media.h"
#include "render/scene/scene.h"
#include "render/surface/surface_maps.h"

namespace kappamu::render {

struct WorldObject {
  std::string name;
  TriangleMesh rest;  ///< in the object's frame, before its deformations [mm]
  TriangleMesh mesh;  ///< as it is
  Surface surface;    ///< surface_of(mesh)
  Rigid world_from_object;
  std::unique_ptr<MovableCaster> rays;  ///< of `mesh`, in the object's frame
  ObjectMedia media;
  std::optional<Polycube> polycube;  ///< that a person has drawn
  BoundaryConstants boundary;
  double roughness = 0.1;
  std::shared_ptr<const SurfaceMaps> maps;  ///< none: a plain surface
  Colour emission = Colour::Zero();         ///< of all its volume, even in all directions [1/mm]

  WorldObject copy() const;
  /// `polycube`, or nullptr.
  const Polycube* drawn() const { return polycube ? &*polycube : nullptr; }
};

/// A point light within a body.
struct InnerLight {
  std::size_t object = 0;
  Eigen::Vector3d position_mm;  ///< in the world's frame
  Colour power;                 ///< [mm²]
};

/// Where a ray meets an object, in the world's frame.
struct WorldHit {
  double distance = 0.0;  ///< [mm]
  std::size_t object = 0;
  std::size_t triangle = 0;          ///< of the object
  double u = 0.0, v = 0.0;           ///< barycentric weights of the second and third corner
  Eigen::Vector3d position, normal;  ///< the triangle's normal, outward
};

class World;
/// Takes a world whose shapes can be seen, before it is known what they are made of.
using ShapesKnown = std::function<void(const World&)>;

class World {
 public:
  /// Reads everything the scene names. Throws InputError naming object, light or camera: no mesh,
  /// no volume, a deformation that the shape does not bear, objects that overlap, the camera or a
  /// spot or projector inside an object.
  World(
      const Scene& scene, std::vector<std::string>& warnings,
      const ShapesKnown& shapes_known = [](const World&) {});
  /// A second world of the same media, whose shapes move on their own.
  World(const World& other);

  const std::vector<WorldObject>& objects() const { return objects_; }
  const std::vector<InnerLight>& inner_lights() const { return inner_lights_; }
  /// The lights that are no inner lights.
  const std::vector<Light>& outer_lights() const { return outer_lights_; }
  /// Other lights, which may have moved into objects or out of them.
  void set_lights(const std::vector<Light>& lights);
  /// Whether light begins inside objects.
  bool lit_inside() const;
  /// An object's material, edited; index and roughness stay where the media state none.
  void set_media(std::size_t object, ObjectMedia media);
  /// An object's vertices, moved; its triangles, and what it is made of, stay. Objects may overlap
  /// from now on.
  void move(std::size_t object, std::vector<Eigen::Vector3d> vertices);
  /// Distances below this are rounding [mm].
  double skin() const { return skin_; }
  double diameter() const { return diameter_; }

  /// `direction` of unit length.
  std::optional<WorldHit> first_hit(
      const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double nearest,
      double farthest = std::numeric_limits<double>::infinity()) const;
  bool blocked(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
               double farthest) const {
    return rays_->any_hit(origin, direction, skin_, farthest - skin_);
  }
  /// The object that holds the point, if any.
  std::optional<std::size_t> object_at(const Eigen::Vector3d& point) const;

 private:
  void expect_apart() const;
  void expect_outside(const Eigen::Vector3d& point, const std::string& what) const;

  std::vector<WorldObject> objects_;
  std::vector<InnerLight> inner_lights_;
  std::vector<Light> outer_lights_;
  std::vector<std::size_t> first_triangle_;    ///< of each object in the common mesh
  std::vector<std::array<int, 3>> triangles_;  ///< of all objects
  std::vector<Eigen::Vector3d> vertices_;      ///< of all objects, in the world's frame
  std::unique_ptr<MovableCaster> rays_;        ///< of them
  double skin_ = 0.0, diameter_ = 0.0;
};

}  // namespace kappamu::render
