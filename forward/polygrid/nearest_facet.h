// The nearest of many triangles.
#pragma once

#include <array>
#include <vector>

#include "core/mesh/box_tree.h"
#include "core/mesh/triangle_mesh.h"

namespace kappamu::forward::polygrid {

using Facet = std::array<Eigen::Vector3d, 3>;

std::vector<Facet> facets_of(const TriangleMesh& mesh);

class Facets {
 public:
  /// At least one; `near`: a distance within which the nearest is to be expected [mm].
  Facets(std::vector<Facet> facets, double near);

  struct Nearest {
    int facet = 0;
    Eigen::Vector3d weights;  ///< barycentric, of the point nearest to the one asked for
  };
  Nearest nearest(const Eigen::Vector3d& p) const;
  Eigen::Vector3d point(const Nearest& nearest) const;

 private:
  std::vector<Facet> facets_;
  BoxTree tree_;
  double near_;
};

}  // namespace kappamu::forward::polygrid
