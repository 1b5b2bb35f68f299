// What a graphics card draws of a world while things move: its triangles' corners in the world's
// frame, and the light of each. Light scattered once, M₁ and L₁ of render/picture/shading.h, is
// that of a deep flat layer (render/live/surface_light.h); where lights are reflected, other
// objects and surfaces are not. At rest the picture is traced (render/live/live_picture.h).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/live/live_scene.h"
#include "render/picture/corner_average.h"

namespace kappamu::render {

class LitCorners {
 public:
  static constexpr int geometry_floats = 7;  ///< position [mm], normal, number of the object
  /// R, G, B each: M − E_t − M₁, E_t, σs'/σt', and the irradiance of each source.
  static constexpr int light_floats(std::size_t sources) {
    return 9 + 3 * static_cast<int>(sources);
  }

  /// Keeps a reference to the world.
  explicit LitCorners(const World& world);

  struct Geometry {
    std::vector<float> corners;                           ///< [corner][geometry_floats]
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< corners of each, of all objects
  };
  /// Of the shapes as they are, whose corners light() is of from then on.
  Geometry geometry();
  /// [corner][light_floats] of the answer's sources; after geometry().
  std::vector<float> light(const LiveAnswer& answer) const;

 private:
  template <int sources>
  std::vector<float> light_of(const LiveAnswer& answer) const;

  const World& world_;
  std::vector<CornerAverage> averages_;
  std::vector<SharedCorners> corners_;  ///< of each object
};

/// Cosines of the view that a row of object_table() has reflectances of, evenly from 0 to 1.
inline constexpr int table_cosines = 33;
/// One row per object of table_cosines + 1 texels of four floats: η, A, R_φ and roughness; then
/// what the surface reflects of even light, in the first.
std::vector<float> object_table(const std::vector<SurfaceLight>& surfaces);

/// The factor that puts the 95th percentile of M/π, over triangles that face `eye` [mm], at a
/// luminance of 0.6; 1 where nothing is lit.
double usual_exposure(const World& world, const LiveAnswer& answer, const Eigen::Vector3d& eye);

}  // namespace kappamu::render
