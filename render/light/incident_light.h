// The light of an object, with the shadows of all objects, as the models of objects take it
// (forward/object_model.h): collimated beams of the lights that have a direction, diffuse
// irradiance of the environment, beams that begin inside it (inner_light.h).
#pragma once

#include <array>
#include <cstdint>

#include "core/progress.h"
#include "forward/object_model.h"
#include "render/light/environment.h"
#include "render/light/light_source.h"
#include "render/scene/world.h"

namespace kappamu::render {

struct IncidentLight {
  std::array<forward::ObjectLight, 3> channels;  ///< R, G, B, in the object's frame
  Colour power = Colour::Zero();                 ///< before Fresnel, and begun inside [mm²]
};

/// Directions towards the environment, of all triangles together. Fewer are noisier.
constexpr double environment_rays = 4e6;

/// Beams arrive at beam_places(): in the middles of triangles or of parts of them, 0.35 mean free
/// paths of the most scattering channel apart, or 1/256 of the object where that is more; triangles
/// smaller than a third of that share places. The environment's irradiance of a triangle is the
/// mean over points on it and directions, half of them drawn by the environment's brightness, half
/// by the cosine (balance heuristic: Veach 1997, 9.2), of low discrepancy and unbiased over `seed`.
/// It is stated as the even light of which as much enters: directions count by what Fresnel lets
/// in, and what surfaces mirror of the environment towards others counts with it. Where the
/// environment's lamps enter as beams (sky_beams.h), it is of the rest.
IncidentLight incident_light(const World& world, std::size_t object, const LightSources& sources,
                             const Environment* environment, std::uint64_t seed, Progress& progress,
                             double rays = environment_rays);

}  // namespace kappamu::render
