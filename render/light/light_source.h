// Lights whose light reaches a point along one ray: directional, point, spot, a projector.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "render/colour.h"
#include "render/scene/scene.h"

namespace kappamu::render {

/// Light at a point, as if nothing stood between.
struct Arrival {
  Eigen::Vector3d direction;  ///< of travel, of unit length
  double distance = 0.0;      ///< to the light [mm]; infinite for directional light
  Colour irradiance;          ///< on a surface that faces the light
};

class LightSource {
 public:
  virtual ~LightSource() = default;
  virtual Arrival at(const Eigen::Vector3d& point) const = 0;
  /// Where it stands; nothing for directional light.
  virtual const Eigen::Vector3d* position() const { return nullptr; }
};

using LightSources = std::vector<std::unique_ptr<LightSource>>;

/// The scene's lights but its environment, in its order. Reads projectors' images: EXR linear,
/// other files as sRGB; a pixel is an even square of light, row 0 on top, seen along the
/// projector's axis. Throws InputError naming the file.
LightSources make_light_sources(const std::vector<Light>& lights);

}  // namespace kappamu::render
