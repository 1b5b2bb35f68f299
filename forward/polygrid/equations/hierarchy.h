// Coarser versions of the seven-point form: aggregates of 2 × 2 × 2 lattice places, each in one
// piece. A link between aggregates has the conductance of the links that cross, times the ratio of
// distances between their ends and between the aggregates' middles: on a box the seven-point form
// of the coarser box. What leaks is summed.
//
// Transfers are constant on aggregates, the coarsest level is solved directly. It preconditions the
// equations, whose seven-point form it is; it need not be the exact coarse equation.
#pragma once

#include <vector>

#include "forward/polygrid/equations/equations.h"

namespace kappamu::forward::polygrid {

struct GraphLevel {
  Pattern links;              ///< of every node to those after it
  std::vector<int> parent;    ///< [node] of the coarser level; empty on the coarsest
  std::vector<int> coarse;    ///< [link] of the coarser level's links, −1 within an aggregate
  std::vector<double> share;  ///< [link] its part of the coarser conductance
};

/// The numbers of one medium on a level.
struct GraphValues {
  std::vector<double> link;      ///< conductances [mm²]
  std::vector<double> diagonal;  ///< what leaks, and the conductances of the node's links [mm²]
};

class Hierarchy {
 public:
  Hierarchy(const Equations& equations, const Polygrid& grid);

  const std::vector<GraphLevel>& level() const { return level_; }  ///< finest first
  std::vector<GraphValues> values(const MediumValues& medium) const;

  static constexpr std::size_t most_coarsest = 160;  ///< nodes that are solved for directly

 private:
  std::vector<GraphLevel> level_;
};

/// What a channel's medium is on the levels, on the host.
struct ChannelLevels {
  ChannelLevels(const Hierarchy& hierarchy, const MediumValues& medium);

  std::vector<GraphValues> graph;
  std::vector<std::vector<double>> inverse_diagonal;  ///< [level]
  std::vector<double> coarsest;                       ///< inverse of the coarsest level's matrix
};

}  // namespace kappamu::forward::polygrid
