#include "forward/boundary_integral/summation/box_pairs.h"

#include <algorithm>

#include "core/numbers/at.h"

namespace kappamu::forward::boundary_integral {

namespace {

/// Boxes whose nearest points are apart by this many decay lengths exchange nothing (e^−28 =
/// 7e-13).
constexpr double out_of_sight = 28.0;

}  // namespace

BoxPairs::BoxPairs(const Octree& tree, double decay)
    : far(tree.boxes.size()), near(tree.boxes.size()) {
  pair(tree, decay, 0, 0);
}

void BoxPairs::pair(const Octree& tree, double decay, int t, int s) {
  const Box &target = tree.boxes[at(t)], &source = tree.boxes[at(s)];
  if (target.targets() == 0 || source.sources() == 0) return;
  const int level = std::max(target.level, source.level);
  // Gaps in widths of the finer level.
  std::array<int, 3> offset{};
  int gap = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int t_low = target.at[axis] << (level - target.level);
    const int t_high = (target.at[axis] + 1) << (level - target.level);
    const int s_low = source.at[axis] << (level - source.level);
    const int s_high = (source.at[axis] + 1) << (level - source.level);
    gap = std::max({gap, t_low - s_high, s_low - t_high});
    offset[axis] = t_low - s_low;
  }
  if (decay * gap * tree.width(level) > out_of_sight) return;
  if (target.level == source.level && gap > 0) {
    far[at(t)].push_back({s, EquivalentSurfaces::translation(offset)});
  } else if (target.leaf() && source.leaf()) {
    near[at(t)].push_back(s);
  } else if (!target.leaf() && !source.leaf() && target.level == source.level) {
    for (const int t_child : target.child) {
      for (const int s_child : source.child) {
        if (t_child >= 0 && s_child >= 0) pair(tree, decay, t_child, s_child);
      }
    }
  } else if (source.leaf() || (!target.leaf() && target.level < source.level)) {
    for (const int child : target.child) {
      if (child >= 0) pair(tree, decay, child, s);
    }
  } else {
    for (const int child : source.child) {
      if (child >= 0) pair(tree, decay, t, child);
    }
  }
}

}  // namespace kappamu::forward::boundary_integral
