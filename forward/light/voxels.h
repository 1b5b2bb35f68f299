// The march of a beam through the voxels of a block, each of which takes light as a whole, wherever
// in it that collides.
#pragma once

#include <utility>

#include "core/grid.h"
#include "forward/light/first_collisions.h"

namespace kappamu::forward {

/// Voxels along a chord.
class Voxels {
 public:
  /// `corner`: that of smallest x, y, z [mm].
  Voxels(const GridShape& shape, Eigen::Vector3d corner)
      : shape_(shape), corner_(std::move(corner)) {}

  void start(const Chord& chord);
  CellStep step(double most);

 private:
  GridShape shape_;
  Eigen::Vector3d corner_;
  Eigen::Vector3d start_ = Eigen::Vector3d::Zero();      ///< of the chord, in voxels
  Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();  ///< its own
  double at_ = 0.0;
};

/// What a beam's march leaves in a medium: `scatter` takes (voxel, power scattered there first).
template <class Scatter>
struct InVoxels {
  const Medium& medium;
  Scatter scatter;

  CellOptics optics(int cell) const {
    const auto k = static_cast<std::size_t>(cell);
    CellOptics result;
    set_lane({medium.kappa[k], medium.mu[k]}, 0, result);
    return result;
  }
  void deposit(int cell, const CornerShares& shares) {
    double power = 0.0;
    for (const OfChannels& share : shares) power += share[0];
    scatter(static_cast<std::size_t>(cell), power);
  }
  static void leave(std::size_t, const OfChannels&) {}  // a box does not meet itself again
};

/// Marches a beam. When no more than `remainder` of it is left, the rest collides where it is. What
/// becomes of its power is in lane 0 of the result.
template <class Scatter>
BeamLight march_voxels(const Walls& walls, const Beam& beam, double remainder, const Medium& medium,
                       const Eigen::Vector3d& corner, Scatter scatter) {
  BeamPath path(walls, beam);
  BeamLight light = entering(path, {beam.power}, remainder);
  Voxels voxels(medium.kappa.shape(), corner);
  PathPlace place;
  CellStep step;
  march([&] { return next_step(path, walls, place, voxels, step) ? &step : nullptr; }, light,
        InVoxels<Scatter>{medium, std::move(scatter)});
  return light;
}

}  // namespace kappamu::forward
