// The equations of a cut mesh and their coarser versions, cube by cube: every level replaces cubes
// by their parents, all of them where the mesh is another with every cube split, else the smallest.
// Coarse functions are fine ones too, so that the sum of a parent's children (element.h) is the
// exact Galerkin matrix, with cut cubes and hanging nodes as without. Cubes and functions serve all
// media (colour channels) at once.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "forward/embedded/equations/cube_elements.h"
#include "forward/embedded/equations/node_space.h"

namespace kappamu::forward::embedded {

/// From a level's cubes to those of the next coarser one.
struct Coarser {
  std::vector<int> parent;  ///< per cube: cube of the coarser level
  std::vector<int> octant;  ///< of the parent; −1 where the cube stays
};

struct Level {
  NodeSpace space;
  Elements elements;
  /// [channel][unknown] 1/d with A ≤ diag(d): the eigenvalues of diag(1/d) A lie in (0, 1]. Zero
  /// where the equation weighs nothing.
  std::vector<std::vector<float>> inverse_scale;
  Coarser coarser;  ///< empty on the coarsest
};

struct Levels {
  std::vector<Level> level;               ///< finest first
  std::vector<Eigen::MatrixXd> coarsest;  ///< per channel: inverse of the coarsest level's matrix

  const NodeSpace& space() const { return level.front().space; }
  std::size_t unknowns() const { return space().unknowns(); }
};

Levels make_levels(const std::vector<Cube>& cubes, Elements elements);

/// Per unknown a cube's corner that is the unknown itself: 8·cube + corner.
std::vector<int> owner_slots(const NodeSpace& space);

/// Calls use(unknown of the coarser level, weight): what a coarser function's value at an unknown,
/// given by its owner slot, is made of.
template <class Use>
void for_coarser_parts(const Coarser& coarser, const NodeSpace& coarse, int owner_slot,
                       const Use& use) {
  const auto cube = static_cast<std::size_t>(owner_slot / 8);
  const int corner = owner_slot % 8, octant = coarser.octant[cube];
  for (int j = 0; j < 8; ++j) {
    const double weight = octant < 0 ? (corner == j ? 1.0 : 0.0) : parent_weight(octant, corner, j);
    if (weight == 0.0) continue;
    const auto parts =
        coarse.parts(static_cast<std::size_t>(coarser.parent[cube]), static_cast<std::size_t>(j));
    for (const int part : parts) use(part, weight * NodeSpace::weight(parts));
  }
}

/// Between the finest level and the next.
class Transfer {
 public:
  explicit Transfer(const Levels& levels) : levels_(levels), owner_(owner_slots(levels.space())) {}
  /// A load, as coarser functions meet it.
  std::vector<double> restricted(const std::vector<double>& load) const;
  /// A coarser function's values at the finest unknowns.
  std::vector<double> prolonged(const std::vector<double>& field) const;

 private:
  const Levels& levels_;
  std::vector<int> owner_;
};

/// For every unknown the cube corners that it has a part in.
struct Incidence {
  std::vector<int> start;  ///< of each unknown, and the end of the last
  std::vector<int> slot;   ///< 8·cube + corner
  explicit Incidence(const NodeSpace& space);
};

}  // namespace kappamu::forward::embedded
