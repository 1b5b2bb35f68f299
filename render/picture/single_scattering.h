// Light scattered once, along a camera's ray refracted into an object ([T] 2.3.1; Jensen 2001,
// section 2.1, with what scatters isotropically by similarity).
//
// At a depth along the ray the light of a directional source is what refracts in where a straight
// line to the source leaves the object, over the refracted path: exact where the surface between is
// flat. Light that crosses a gap, or another object, does not arrive.
#pragma once

#include <cstdint>
#include <optional>

#include "render/light/environment.h"
#include "render/light/light_source.h"
#include "render/scene/world.h"

namespace kappamu::render {

class SingleScattering {
 public:
  /// Keeps references to both.
  SingleScattering(const World& world, const LightSources& sources)
      : world_(world), sources_(sources) {}

  /// Radiance inside, at a point on the surface, that travels against `inward` (unit length,
  /// world's frame), per unit solid angle inside. Unbiased over uniform (u, v) in [0, 1)². `sky`: a
  /// further light, of this sample alone.
  Colour radiance_inside(const WorldHit& hit, const Eigen::Vector3d& inward, double u, double v,
                         const std::optional<Arrival>& sky = std::nullopt) const;

  /// The same of an environment's lamps behind the object, whose light crosses it without a
  /// collision and, on its way out, one smooth surface.
  Colour sky_through(const WorldHit& hit, const Eigen::Vector3d& inward,
                     const Environment& environment) const;

  /// The same of light that the object emits itself and that does not scatter.
  Colour emitted(const WorldHit& hit, const Eigen::Vector3d& inward, double u, double v) const;

 private:
  /// ∫ σt' ds of each channel along a path in the object.
  Colour optical_depth(const WorldObject& object, const Eigen::Vector3d& from,
                       const Eigen::Vector3d& to) const;
  Colour arriving(std::size_t object, const Eigen::Vector3d& point, const Arrival& arrival) const;

  const World& world_;
  const LightSources& sources_;
};

}  // namespace kappamu::render
