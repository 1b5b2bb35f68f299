// The paper's solution on a polygrid ([W] 5.2, 5.3), for charts: Jacobi's relaxation of κφ on six
// weights per node, alone, from coarse to fine on three levels, and with deep nodes kept from the
// coarser level.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/object_medium.h"
#include "studies/polygrid/laplacian_weights.h"

namespace kappamu::studies {

using namespace forward;
using namespace forward::polygrid;

/// A level with its material and light; κ and μ of interior nodes, q of boundary nodes.
struct RelaxationLevel {
  NodeGrid grid;
  LaplacianWeights weights;
  std::vector<Coefficients> of_node;
  std::vector<double> q;
  std::vector<int> depth;  ///< links to the nearest boundary node, 1 beside it
};

/// The finest level and `levels` − 1 coarser ones; material and light are means over the children.
std::vector<RelaxationLevel> relaxation_levels(const Polygrid& grid,
                                               std::span<const Coefficients> of_cell,
                                               std::span<const double> q, int levels);

/// φ at interior nodes and at boundary nodes.
struct NodeFluence {
  std::vector<double> node, boundary;
};

/// Steps of relaxation on a level ([W] 5.2's two updates; A in C's place). Nodes deeper than
/// `depth` (0: none) stay. Calls `after(processed)` with the nodes that a step updated, boundary
/// nodes included.
void relax(const RelaxationLevel& level, double A, int steps, int depth, NodeFluence& fluence,
           const std::function<void(std::size_t processed)>& after);

/// The coarser level's values at the finer level's nodes.
NodeFluence from_coarser(const RelaxationLevel& fine, const NodeFluence& coarse);

}  // namespace kappamu::studies
