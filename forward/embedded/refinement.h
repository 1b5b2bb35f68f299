// Which cubes to split next: where the surface folds within a cube, and where the gradient of the
// fluence changes most.
#pragma once

#include "forward/embedded/discretisation.h"

namespace kappamu::forward::embedded {

/// Leaves in which the surface turns so much that two of its sides may lie in one cube.
std::vector<int> folds(const CutMesh& mesh, const Surface& surface);

/// Cubes whose children are leaves, and how much splitting them changed.
struct Indicator {
  std::vector<int> node;      ///< of the octree
  std::vector<double> value;  ///< dimensionless
  std::vector<double> cubes;  ///< how many children
  std::vector<char> at_surface;
};
/// Energy ∫ κ |∇φ − mean ∇φ|² of the gradient's variation among the children of each cube, summed
/// over channels and lights, each relative to its light's sum. `weighs_last`: the last light of
/// each channel is even light on all of the surface. Its fluence is also what a place inside adds
/// to the surface's exitance, by reciprocity, so that each other light's energy is multiplied by
/// its own and the root taken: cubes about a light deep inside are refined no further than the
/// surface shows.
Indicator gradient_indicator(const Discretisation& discretisation,
                             const std::vector<Answer>& channels, bool weighs_last = false);

/// How often to split each node so that `left` of the error is left, with the fewest cubes and
/// about `most_cubes` at most.
std::vector<int> splits(const Indicator& indicator, double left, std::size_t most_cubes);

}  // namespace kappamu::forward::embedded
