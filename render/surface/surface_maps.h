// The maps of a surface, read and laid on a mesh.
#pragma once

#include <array>
#include <memory>

#include "core/image.h"
#include "core/mesh/triangle_mesh.h"
#include "render/surface/surface_detail.h"

namespace kappamu::render {

/// A place of an object's surface.
struct SurfacePlace {
  std::size_t triangle = 0;
  double u = 0.0, v = 0.0;        ///< barycentric weights of the second and third corner
  Eigen::Vector3d point, normal;  ///< in the object's frame; the normal of unit length
};

/// A reflectance that lies on an object as its volume does.
class PlacedReflectance {
 public:
  virtual ~PlacedReflectance() = default;
  virtual Colour at(const SurfacePlace& place) const = 0;
};

class SurfaceMaps {
 public:
  /// Of a mesh in the object's frame, which is copied where it is needed; `measured` where the
  /// detail asks for it. Throws InputError naming the file, and where a map needs texture
  /// coordinates that the mesh does not have.
  SurfaceMaps(const SurfaceDetail& detail, const TriangleMesh& mesh,
              std::shared_ptr<const PlacedReflectance> measured = nullptr);

  using Place = SurfacePlace;
  /// The normal, tilted by the bumps' slope.
  Eigen::Vector3d normal(const Place& place) const;
  /// `otherwise` without a gloss map.
  double roughness(const Place& place, double otherwise) const;
  Colour reflectance(const Place& place) const;
  bool reflects() const { return detail_.reflectance.maxCoeff() > 0.0; }

 private:
  /// A point of an image, and how it moves with a point of the surface [1/mm].
  struct OnImage {
    double weight = 1.0;
    Eigen::Vector2d at;
    std::array<Eigen::Vector3d, 2> along;
  };
  std::array<OnImage, 3> on_image(const SurfaceImage& image, const Place& place) const;
  Colour value(const Image<float>& pixels, const SurfaceImage& image, const Place& place) const;

  SurfaceDetail detail_;
  std::shared_ptr<const PlacedReflectance> measured_;
  TriangleMesh mesh_;  ///< empty where all maps are projected
  Image<float> bump_, gloss_, reflectance_;
};

}  // namespace kappamu::render
