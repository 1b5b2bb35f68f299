// Which boxes of an octree exchange their charges by equivalent surfaces, and which point by point.
#pragma once

#include <vector>

#include "forward/boundary_integral/summation/equivalent_surface.h"
#include "forward/boundary_integral/summation/octree.h"

namespace kappamu::forward::boundary_integral {

struct FarBox {
  int source = 0;  ///< box
  Translation translation;
};

/// Boxes that a kernel of `decay` [1/mm] hardly spans exchange nothing.
struct BoxPairs {
  BoxPairs(const Octree& tree, double decay);

  std::vector<std::vector<FarBox>> far;  ///< per target box, of its level
  std::vector<std::vector<int>> near;    ///< per target leaf: source leaves

 private:
  /// Decides how the sources of box s reach the targets of box t.
  void pair(const Octree& tree, double decay, int t, int s);
};

}  // namespace kappamu::forward::boundary_integral
