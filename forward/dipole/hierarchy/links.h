// Which clusters exchange light as wholes: links from emitting to receiving clusters such that
// every pair of triangles is covered once, either by a link or by two leaves too near for one
// ([M] 3.2, 5.2).
#pragma once

#include <cstddef>
#include <vector>

#include "forward/dipole/hierarchy/cluster_tree.h"

namespace kappamu::forward::dipole {

/// A link holds where both clusters are small against the length over which R_d changes at their
/// distance, (ρ_R + ρ_E)(1/s + σ/3) <= opening, s² = r² + z². That is [M]'s limit on the solid
/// angle, seen from z below the surface and from both ends, with the decay beside it: R_d falls
/// like s⁻³e^(−σs). Where e^(−σs) leaves little to be wrong about, the decay's share of the limit
/// is relaxed by e^(σs/6): at equal error the work is least where ρ ∝ R_d''^(−1/6).
struct Oracle {
  float opening = 0.68F;     ///< dimensionless
  float smooth = 0.0F;       ///< z: R_d does not change over shorter lengths [mm]
  float decay = 0.0F;        ///< σ_tr, the largest of all channels [1/mm]
  float least_decay = 0.0F;  ///< the smallest [1/mm]

  bool holds(const Eigen::Array4f& receiver, const Eigen::Array4f& emitter) const;
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

/// From the root down, as [M] 5.2: the larger of two clusters is opened. Results are the same on
/// any number of cores.
Links link(const ClusterTree& tree, const Oracle& oracle);

/// What update() did to links of clusters that have moved or that another material links otherwise.
struct LinkChanges {
  std::size_t failing = 0;   ///< links beyond the wide oracle, before
  std::size_t demoted = 0;   ///< of them, replaced by links further down
  std::size_t promoted = 0;  ///< pairs of links replaced by one further up
  std::size_t pending() const { return failing - demoted; }
};

/// [M] 5.5: links that do not hold within `wide` move down the hierarchy until they hold within
/// `narrow`, those first that are the farthest from it; pairs of links that hold within `narrow` as
/// one move up one level. At most `most` links move. Every pair of triangles stays covered once.
/// Where more than `all_anew` of the links fail, and all may move, link() makes them anew.
LinkChanges update(Links& links, const ClusterTree& tree, const Oracle& wide, const Oracle& narrow,
                   std::size_t most);
inline constexpr double all_anew = 0.25;

}  // namespace kappamu::forward::dipole
