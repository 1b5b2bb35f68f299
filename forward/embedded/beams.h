// First collisions of collimated beams in an octree's cubes (forward/light/first_collisions.h).
#pragma once

#include <span>

#include "forward/embedded/equations/fields.h"
#include "forward/light/first_collisions.h"

namespace kappamu::forward::embedded {

/// A light's beams with their paths, which grow where light goes on along them.
struct BeamPaths {
  BeamPaths(const Walls& walls, const std::vector<Beam>& beams);

  const Walls& walls;
  std::vector<BeamPath> path;  ///< one per beam
};

/// A channel's beams, one for each path.
struct ChannelBeams {
  const std::vector<Coefficients>* coefficients;  ///< per cube
  const std::vector<Beam>* beams;
  std::vector<double>* load;  ///< per unknown
  ObjectBalance* balance;
  std::vector<Beam>* leaving;  ///< unscattered
};

/// Adds ∫ S N dV of every beam to the channel's load, and where its power goes to the balance.
/// Channels whose beams run alike are marched at once.
void add_beams(const Octree& tree, const CutMesh& mesh, const NodeSpace& space, BeamPaths& paths,
               std::span<const ChannelBeams> channels);

}  // namespace kappamu::forward::embedded
