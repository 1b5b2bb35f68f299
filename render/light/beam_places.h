// Where on an object beams of lights arrive. Places depend on the object alone: for lights that
// move from frame to frame they are found once.
#pragma once

#include <Eigen/Core>
#include <array>
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

/// How far apart places lie [mm].
struct BeamSpacing {
  double of_parts = 1.0;   ///< of the congruent parts that a larger triangle is seen as
  double of_shared = 1.0;  ///< triangles smaller than its square share places so far apart
};

/// At the middles of triangles, which is second order in their size; of a larger triangle, at the
/// middles of k² congruent parts. All small triangles in a cube of the object's space that face
/// alike have one place together. In the order of the triangles; areas sum to the surface's, and
/// so does light that comes from afar.
std::vector<BeamPlace> beam_places(const WorldObject& object, const BeamSpacing& spacing);

/// One place in the middle of each triangle.
std::vector<BeamPlace> middles_of(const WorldObject& object);

using BeamsOfChannels = std::array<std::vector<forward::Beam>, 3>;  ///< R, G, B
/// Those of the sources that light a place, with the shadows of all objects.
void add_beams(const World& world, const WorldObject& object, const LightSources& sources,
               const BeamPlace& place, BeamsOfChannels& out);

std::array<forward::ObjectLight, 3> beams_at(const World& world, std::size_t object,
                                             const LightSources& sources,
                                             std::span<const BeamPlace> places);

}  // namespace kappamu::render
