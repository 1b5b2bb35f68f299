// Where on an object beams of lights arrive that move from frame to frame: places are found once.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "forward/object_model.h"
#include "render/light/light_source.h"
#include "render/scene/world.h"

namespace kappamu::render {

/// A point of the surface and the area that it stands for, in the object's frame.
struct BeamPlace {
  int triangle = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [mm]
  Eigen::Vector3d area = Eigen::Vector3d::Zero();      ///< along its normals [mm²]
};

/// About `spacing_mm` apart, in the order of the triangles: several on large triangles, of low
/// discrepancy over `seed`; one for all small triangles in a cube of the object's space that face
/// alike. Areas sum to the surface's; so does light that comes from afar.
std::vector<BeamPlace> beam_places(const WorldObject& object, double spacing_mm,
                                   std::uint64_t seed);

using BeamsOfChannels = std::array<std::vector<forward::Beam>, 3>;  ///< R, G, B
/// Those of the sources that light a place, with the shadows of all objects.
void add_beams(const World& world, const WorldObject& object, const LightSources& sources,
               const BeamPlace& place, BeamsOfChannels& out);

std::array<forward::ObjectLight, 3> beams_at(const World& world, std::size_t object,
                                             const LightSources& sources,
                                             std::span<const BeamPlace> places);

}  // namespace kappamu::render
