// Which clusters exchange light as wholes: links from emitting to receiving clusters such that
// every pair of triangles is covered once, either by a link or by two leaves too near for one
// ([M] 3.2, 5.2).
#pragma once

#include <cstddef>
#include <vector>

#include "forward/dipole/hierarchy/cluster_tree.h"

namespace kappamu::forward::dipole {

/// How far apart, and how small, clusters must be to exchange light as wholes (meeting.inc).
struct Oracle {
  float opening = 0.68F;     ///< dimensionless
  float smooth = 0.0F;       ///< z: R_d does not change over shorter lengths [mm]
  float decay = 0.0F;        ///< σ_tr, the largest of all channels [1/mm]
  float least_decay = 0.0F;  ///< the smallest [1/mm]

  enum class Meeting { linked, emitter_opens, receiver_opens };
  Meeting meet(const ClusterTree& tree, std::size_t receiver, std::size_t emitter) const;
  bool holds(const ClusterTree& tree, std::size_t receiver, std::size_t emitter) const {
    return meet(tree, receiver, emitter) == Meeting::linked;
  }
};

/// Places of a receiver in a list of emitters.
struct LinkRange {
  int first = 0, count = 0;
};

struct Links {
  std::vector<LinkRange> of_cluster;  ///< per cluster, in `emitter`
  std::vector<int> emitter;           ///< clusters
  std::vector<LinkRange> of_leaf;     ///< per leaf (from 0), in `near`
  std::vector<int> near;              ///< leaves (from 0) to be summed triangle by triangle
};

/// From the root down, as [M] 5.2; one receiver after the other: the reference of links.cl, which
/// finds the same links.
Links link(const ClusterTree& tree, const Oracle& oracle);

/// Emitters of every list in the order of their triangles, which update() expects and link() gives.
void put_in_order(Links& links, const ClusterTree& tree);

/// What update() did to links of clusters that have moved or that another material links otherwise.
struct LinkChanges {
  std::size_t failing = 0;   ///< links beyond the wide oracle, before
  std::size_t demoted = 0;   ///< of them, replaced by links further down
  std::size_t promoted = 0;  ///< pairs of links replaced by one further up
  bool too_many = false;     ///< all links are to be made anew; none has moved
  std::size_t pending() const { return failing - demoted; }
};

/// [M] 5.5: links that do not hold within `wide` move down the hierarchy until they hold within
/// `narrow`, those first that are the farthest from it; pairs of links that hold within `narrow` as
/// one move up one level. At most `most` links move. Every pair of triangles stays covered once.
/// Where more than `all_anew` of the links fail, and all may move, it moves none and sets too_many.
LinkChanges update(Links& links, const ClusterTree& tree, const Oracle& wide, const Oracle& narrow,
                   std::size_t most);
inline constexpr double all_anew = 0.25;

}  // namespace kappamu::forward::dipole
