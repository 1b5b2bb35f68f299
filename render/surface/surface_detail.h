// What pictures add to an object's surface: bump and gloss ([T] 3.4.4), and diffuse reflectance
// over what is scattered inside ([W] 6.1). Maps lie on the surface by the mesh's texture
// coordinates, or are projected along the object's three axes.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "render/colour.h"

namespace kappamu::render {

/// Values repeat beyond the image's edges.
struct SurfaceImage {
  std::filesystem::path file;
  /// Of the image, projected along the axis that the surface faces, mixed where it turns [mm];
  /// none: texture coordinates 0 to 1 are the image, v upwards.
  std::optional<Eigen::Vector2d> size_mm;
};

struct SurfaceDetail {
  std::optional<SurfaceImage> bump;  ///< heights, 0 to 1
  double depth_mm = 0.0;             ///< of the height 1
  std::optional<SurfaceImage> gloss;
  double dull = 0.5, glossy = 0.1;      ///< roughness where the gloss image is 0, and 1
  Colour reflectance = Colour::Zero();  ///< of the surface: a factor on its image, if it has one
  std::optional<SurfaceImage> reflectance_image;
  /// `reflectance` is a factor on the one that was measured with the material's volume.
  bool reflectance_measured = false;

  bool any() const { return bump || gloss || reflectance.maxCoeff() > 0.0; }
};

}  // namespace kappamu::render
