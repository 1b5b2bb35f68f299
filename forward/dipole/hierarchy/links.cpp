#include "forward/dipole/hierarchy/links.h"

#include <algorithm>
#include <cmath>

namespace kappamu::forward::dipole {

namespace {

using std::sqrt;
float least_of(float a, float b) {
  return std::min(a, b);
}
#include "forward/dipole/hierarchy/meeting.inc"

}  // namespace

Oracle::Meeting Oracle::meet(const ClusterTree& tree, std::size_t receiver,
                             std::size_t emitter) const {
  const Eigen::Array4f &here = tree.cluster()[receiver], &there = tree.cluster()[emitter];
  const Eigen::Array4f apart = here - there;
  switch (meeting(here[3], tree.leaf(receiver), there[3], tree.leaf(emitter), apart[0], apart[1],
                  apart[2], opening, smooth, decay, least_decay)) {
    case LINKED:
      return Meeting::linked;
    case EMITTER_OPENS:
      return Meeting::emitter_opens;
    default:
      return Meeting::receiver_opens;
  }
}

Links link(const ClusterTree& tree, const Oracle& oracle) {
  Links links;
  std::vector<std::vector<int>> left(tree.clusters());  // to the children of each
  std::vector<int> open;                                // the next one last
  for (std::size_t k = 0; k < tree.clusters(); ++k) {
    const auto first = static_cast<int>(links.emitter.size());
    open = k > 0 ? left[(k - 1) / 2] : std::vector<int>{0};
    std::reverse(open.begin(), open.end());
    while (!open.empty()) {
      const int e = open.back();
      open.pop_back();
      switch (oracle.meet(tree, k, static_cast<std::size_t>(e))) {
        case Oracle::Meeting::linked:
          links.emitter.push_back(e);
          break;
        case Oracle::Meeting::emitter_opens:
          open.push_back(2 * e + 2);
          open.push_back(2 * e + 1);
          break;
        case Oracle::Meeting::receiver_opens:
          left[k].push_back(e);
      }
    }
    links.of_cluster.push_back({first, static_cast<int>(links.emitter.size()) - first});
    if (!tree.leaf(k)) continue;
    links.of_leaf.push_back(
        {static_cast<int>(links.near.size()), static_cast<int>(left[k].size())});
    for (const int e : left[k]) links.near.push_back(e - static_cast<int>(tree.first_leaf()));
  }
  return links;
}

}  // namespace kappamu::forward::dipole
