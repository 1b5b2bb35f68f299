// The equations of a cut mesh and their coarser versions, cube by cube: every level replaces the
// smallest cubes by their parents. Coarse functions are fine ones too, so that the sum of a
// parent's children (element.h) is the exact Galerkin matrix, with cut cubes and hanging nodes as
// without. Cubes and functions serve all media (colour channels) at once.
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
  std::size_t channels() const { return coarsest.size(); }
};

Levels make_levels(const std::vector<Cube>& cubes, Elements elements);

/// Per unknown a cube's corner that is the unknown itself: 8·cube + corner.
std::vector<int> owner_slots(const NodeSpace& space);

/// For every unknown the cube corners that it has a part in.
struct Incidence {
  std::vector<int> start;  ///< of each unknown, and the end of the last
  std::vector<int> slot;   ///< 8·cube + corner
  explicit Incidence(const NodeSpace& space);
};

}  // namespace kappamu::forward::embedded
