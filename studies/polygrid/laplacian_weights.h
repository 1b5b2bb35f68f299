// The named baseline of polygrids: six Laplacian weights per node ([W] appendix B), where they can
// be used, and a flux form where they cannot.
#pragma once

#include <array>
#include <vector>

#include "forward/polygrid/polygrid.h"

namespace kappamu::studies {

using namespace forward;
using namespace forward::polygrid;

/// Nodes and links of a polygrid or of a coarser level of one ([W] 5.3), without the cells' shapes.
struct NodeGrid {
  std::vector<Eigen::Vector3d> node;           ///< interior [mm]
  std::vector<std::array<int, 6>> link;        ///< as Polygrid::link
  std::vector<Eigen::Vector3d> boundary_node;  ///< [mm]
  std::vector<int> boundary_cell;              ///< the interior node of each
  std::vector<int> parent;                     ///< interior node of the coarser level; empty: none
  std::vector<int> boundary_parent;            ///< boundary node of the coarser level
  std::vector<Eigen::Vector3i> place;
  std::vector<int> outer_side;  ///< of nodes of a layer; −1 in the core
};
NodeGrid node_grid(const Polygrid& grid);
/// Positions are means of those of the up to eight children ([W] 5.3). Fills in `fine`'s parents.
NodeGrid coarser(NodeGrid& fine);

/// What became of a node's 6 × 6 system.
enum class WeightKind {
  paper,           ///< solved, all six positive
  negative,        ///< solved, one or more negative: replaced
  ill_conditioned  ///< not solved for: replaced
};

struct LaplacianWeights {
  std::vector<std::array<double, 6>> weight;  ///< w_j of [W] (9), by link [1/mm²]
  std::vector<WeightKind> kind;               ///< per interior node
  int negative = 0, ill_conditioned = 0;
};

enum class NegativeWeights { kept, replaced };

/// Σ_j w_j (f_j − f_0) ≈ ∇²f at every interior node, by the system of appendix B in the frame that
/// the node's links span. Where the system's condition exceeds 1e4, or a weight is negative and not
/// to be kept, the flux form takes its place: w_j = (half the node's extent along that link's axis
/// times its length)⁻¹, positive always, so that the maximum principle holds; of first order only.
LaplacianWeights laplacian_weights(const NodeGrid& grid,
                                   NegativeWeights negative = NegativeWeights::replaced);

}  // namespace kappamu::studies
