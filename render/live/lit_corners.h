// What a graphics card draws of a world: its triangles' corners in the world's frame, and the light
// that each sends out. Seen is the light that diffusion lets out, refracted (render/picture/
// shading.h without M₁ and L₁); reflections at the surface are not in it.
#pragma once

#include <vector>

#include "render/live/live_scene.h"
#include "render/picture/corner_average.h"

namespace kappamu::render {

class LitCorners {
 public:
  static constexpr int geometry_floats = 9;  ///< position [mm], normal, η, A, R_φ
  static constexpr int light_floats = 6;     ///< M − E_t and E_t, R, G, B each

  /// Keeps a reference to the world.
  explicit LitCorners(const World& world);

  std::size_t corners() const { return corners_; }           ///< three per triangle, of all objects
  std::vector<float> geometry() const;                       ///< [corner][geometry_floats]
  std::vector<float> light(const LiveAnswer& answer) const;  ///< [corner][light_floats]

 private:
  const World& world_;
  std::size_t corners_ = 0;
  std::vector<CornerAverage> averages_;
};

/// The factor that puts the 95th percentile of M/π, over triangles that face `eye` [mm], at a
/// luminance of 0.6; 1 where nothing is lit.
double usual_exposure(const World& world, const LiveAnswer& answer, const Eigen::Vector3d& eye);

}  // namespace kappamu::render
