// The light of an object, with the shadows of all objects, as the models of objects take it
// (forward/object_model.h): collimated beams of the lights that have a direction, diffuse
// irradiance of the environment, beams that begin inside it (inner_light.h).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/progress.h"
#include "forward/object_model.h"
#include "render/light/beam_places.h"
#include "render/light/environment.h"
#include "render/scene/world.h"

namespace kappamu::render {

struct IncidentLight {
  std::array<forward::ObjectLight, 3> channels;  ///< R, G, B, in the object's frame
  Colour power = Colour::Zero();                 ///< before Fresnel, and begun inside [mm²]
};

/// Directions towards the environment, of all triangles together. Fewer are noisier.
constexpr double environment_rays = 4e6;

/// Where on an object beams arrive: beam_places() in the middles of triangles or of parts of them,
/// 0.35 mean free paths of the most scattering channel apart, or 1/256 of the object where that is
/// more; triangles smaller than a third of that share places.
std::vector<BeamPlace> incident_places(const WorldObject& object);

/// Of an environment, what enters evenly.
struct DiffuseLight {
  std::array<std::vector<double>, 3> irradiance;  ///< R, G, B, per triangle, before Fresnel
  Colour power = Colour::Zero();                  ///< that arrives [mm²]
};

/// The irradiance of a triangle is the mean over points on it and directions, half of them drawn by
/// the environment's brightness, half by the cosine (balance heuristic: Veach 1997, 9.2), of low
/// discrepancy and unbiased over `seed`. It is stated as the even light of which as much enters:
/// directions count by what Fresnel lets in, and what surfaces mirror of the environment towards
/// others counts with it. Where the environment's lamps enter as beams (sky_beams.h), it is of the
/// rest. `rays`: of all triangles together.
DiffuseLight diffuse_light(const World& world, std::size_t object, const Environment& environment,
                           std::uint64_t seed, Progress& progress, double rays);

/// Beams of the sources, and of the environment's lamps where they enter as beams, at each place;
/// `rays`: towards the lamps, of all places together.
BeamsOfChannels beams_of_lights(const World& world, std::size_t object, const LightSources& sources,
                                const Environment* environment, std::span<const BeamPlace> places,
                                std::uint64_t seed, Progress& progress, double rays);

/// All of it, by environment_rays.
IncidentLight incident_light(const World& world, std::size_t object, const LightSources& sources,
                             const Environment* environment, std::uint64_t seed,
                             Progress& progress);

}  // namespace kappamu::render
