// A collimated beam's way through an object or a block: refracted in, reflected inside at every
// wall that it meets, by Snell's and Fresnel's laws. It depends on the walls and on eta alone.
#pragma once

#include <vector>

#include "forward/light/walls.h"

namespace kappamu::forward {

/// A straight part of the way, from wall to wall.
struct Chord {
  Eigen::Vector3d from, direction;  ///< [mm], unit
  double length = 0.0;              ///< [mm]
  int meets = 0;                    ///< the wall at its end
  double leaves = 1.0;              ///< there, of what arrives; the rest is reflected inside
};

/// Whether a beam flies to its triangle from inside: `normal` is the triangle's.
inline bool begins_inside(const Beam& beam, const Eigen::Vector3d& normal) {
  return beam.direction.dot(normal) > 0.0;
}

class BeamPath {
 public:
  /// Throws InputError where the beam meets its triangle from inside and did not begin there.
  BeamPath(const Walls& walls, const Beam& beam);

  double transmitted() const { return transmitted_; }  ///< share of the beam's power that enters
  bool from_inside() const { return from_inside_; }    ///< it begins inside
  int enters() const { return enters_; }  ///< the wall there; of a beam that begins inside, ahead
  /// The part number `k`, each asked for in turn; a path grows as far as it is asked for. None:
  /// everything has left, or it slipped out along an edge of the mesh.
  const Chord* chord(std::size_t k, const Walls& walls);

 private:
  void go_on(const Walls& walls, Eigen::Vector3d from, const Eigen::Vector3d& direction,
             int triangle);
  void add_chord(const Walls& walls, const Eigen::Vector3d& from, const Eigen::Vector3d& direction,
                 const RayHit& hit);

  int enters_;
  bool from_inside_ = false;
  double transmitted_;
  std::vector<Chord> chords_;
};

/// What leaves at a chord's end goes on outside as this.
Beam leaving(const Walls& walls, const Chord& chord, double power);

/// Adds to `beams` where a beam that leaves by its triangle meets the object again, and where what
/// is reflected there does. The power that meets it, before Fresnel.
double meet_again(const MeshWalls& walls, Beam beam, std::vector<Beam>& beams);

}  // namespace kappamu::forward
