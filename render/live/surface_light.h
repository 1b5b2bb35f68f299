// What a picture needs of surfaces beside their exitance while things move: where lights arrive
// unshadowed, and how much of the light below the surface is scattered.
#pragma once

#include <memory>
#include <vector>

#include "core/optics.h"
#include "render/light/light_source.h"
#include "render/scene/world.h"

namespace kappamu::render {

/// Sources that are drawn while things move, the first of a scene.
inline constexpr std::size_t most_drawn_sources = 4;

/// Of each triangle of an object, a hundredth of a mean free path below its middle.
struct BelowSurface {
  std::vector<Colour> albedo;  ///< σs'/σt' = 1 − 3κμ
  /// Radiance inside of what the object emits and is not scattered on its way, ε/(4πσt') of a deep
  /// layer; empty: it does not glow.
  std::vector<Colour> glow;
};
BelowSurface below_surface(const WorldObject& object);

/// Irradiance on a surface that faces the source, in the middle of each triangle; 0 in shadow and
/// where the source is behind the surface: [source][triangle].
using Arriving = std::vector<std::vector<Eigen::Array3f>>;

/// Of one object.
struct SurfaceLight {
  BoundaryConstants boundary;
  double roughness = 0.1;
  std::shared_ptr<const BelowSurface> below;
  Arriving arriving;
};

/// Of the first most_drawn_sources.
Arriving arriving_on(const World& world, std::size_t object, const LightSources& sources);

/// Radiance inside of light scattered once, on its way to the eye, below a flat surface, over the
/// irradiance that the surface lets in per area across the refracted beam and σs'/σt'; cosines
/// inside (Hanrahan and Krueger 1993, for a deep layer) [1/sr].
double once_scattered(double cos_light_inside, double cos_view_inside);

/// M₁ of the same per the same: ∫ (1−R)/η² once_scattered cosθ dω over the directions outside, by
/// the light's cosine inside, at `steps` + 1 even cosines from 0 to 1.
std::vector<double> exitance_once_scattered(double eta, int steps);

}  // namespace kappamu::render
