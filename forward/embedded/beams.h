// First collisions of collimated beams: refracted into the object, marched cube by cube, exact for
// coefficients constant in each (embedded.md).
#pragma once

#include <span>

#include "forward/embedded/equations/fields.h"
#include "forward/object_model.h"

namespace kappamu::forward::embedded {

/// Where the power of a light's beams goes, after Fresnel [mm²]; the last three sum to the first.
struct BeamPowers {
  double entering = 0.0;
  double scattered = 0.0;    ///< added to the load
  double absorbed = 0.0;     ///< at the first collision
  double unscattered = 0.0;  ///< left without one
};

/// A beam refracted into the object, up to the surface that it meets next.
struct Chord {
  Eigen::Vector3d from, direction;  ///< [mm], unit
  double length = 0.0;              ///< [mm]
  double transmitted = 0.0;         ///< share of the power that enters
};
/// Throws InputError where a beam meets the surface from inside.
std::vector<Chord> chords_of(const ObjectProblem& problem, const std::vector<Beam>& beams);

/// A channel's beams, one for each chord.
struct ChannelBeams {
  const std::vector<Coefficients>* coefficients;  ///< per cube
  const std::vector<Beam>* beams;
  std::vector<double>* load;  ///< per unknown
};

/// Adds ∫ S N dV of every beam to the channel's load; S = σs'/σt' of the power that collides in a
/// cube, along the beam's chord through it. Channels whose beams run alike are marched at once.
std::vector<BeamPowers> add_beams(const Octree& tree, const CutMesh& mesh, const NodeSpace& space,
                                  const std::vector<Chord>& chords,
                                  std::span<const ChannelBeams> channels);

}  // namespace kappamu::forward::embedded
