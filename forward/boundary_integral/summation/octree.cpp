#include "forward/boundary_integral/summation/octree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace kappamu::forward::boundary_integral {

namespace {

constexpr int most_levels = 20;

/// Sorts elements [begin, end) by the octant of `middle` that they lie in; returns where each
/// octant begins, and the end.
std::array<int, 9> sort_by_octant(const std::vector<Place>& places, const Eigen::Vector3d& middle,
                                  std::vector<int>& order, int begin, int end) {
  const auto octant = [&](int element) {
    const Eigen::Vector3d& p = places[static_cast<std::size_t>(element)].centre;
    return (p.x() >= middle.x() ? 1 : 0) + (p.y() >= middle.y() ? 2 : 0) +
           (p.z() >= middle.z() ? 4 : 0);
  };
  std::array<int, 9> first{};
  first[8] = end;
  const auto start = order.begin() + begin;
  std::stable_sort(start, order.begin() + end, [&](int a, int b) { return octant(a) < octant(b); });
  for (int o = 0; o < 8; ++o) {
    first[static_cast<std::size_t>(o)] = static_cast<int>(
        std::partition_point(start, order.begin() + end, [&](int e) { return octant(e) < o; }) -
        order.begin());
  }
  return first;
}

bool within(const std::vector<Place>& places, const std::vector<int>& order, int begin, int end,
            double reach) {
  return std::all_of(order.begin() + begin, order.begin() + end, [&](int element) {
    return places[static_cast<std::size_t>(element)].reach <= reach;
  });
}

}  // namespace

Octree make_octree(const std::vector<Place>& sources, const std::vector<Place>& targets, int most) {
  Octree tree;
  Eigen::AlignedBox3d bounds;
  for (const Place& p : sources) bounds.extend(p.centre);
  for (const Place& p : targets) bounds.extend(p.centre);
  tree.root_width = bounds.sizes().maxCoeff() * (1.0 + 1e-9);
  tree.corner = bounds.center() - Eigen::Vector3d::Constant(0.5 * tree.root_width);
  tree.source.resize(sources.size());
  tree.target.resize(targets.size());
  std::iota(tree.source.begin(), tree.source.end(), 0);
  std::iota(tree.target.begin(), tree.target.end(), 0);
  Box root;
  root.end_source = static_cast<int>(sources.size());
  root.end_target = static_cast<int>(targets.size());
  tree.boxes.push_back(root);
  tree.level_begin = {0, 1};
  for (int level = 0; level < most_levels; ++level) {
    const int begin = tree.level_begin[static_cast<std::size_t>(level)];
    const int end = tree.level_begin[static_cast<std::size_t>(level) + 1];
    for (int b = begin; b < end; ++b) {
      const Box box = tree.boxes[static_cast<std::size_t>(b)];
      if (std::max(box.sources(), box.targets()) <= most) continue;
      const double reach = box_reach * tree.width(level + 1);
      if (!within(sources, tree.source, box.first_source, box.end_source, reach) ||
          !within(targets, tree.target, box.first_target, box.end_target, reach)) {
        continue;
      }
      const Eigen::Vector3d middle = tree.centre(box);
      const auto s = sort_by_octant(sources, middle, tree.source, box.first_source, box.end_source);
      const auto t = sort_by_octant(targets, middle, tree.target, box.first_target, box.end_target);
      for (std::size_t o = 0; o < 8; ++o) {
        if (s[o] == s[o + 1] && t[o] == t[o + 1]) continue;
        Box child;
        child.level = level + 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          child.at[axis] = 2 * box.at[axis] + static_cast<int>(o >> axis & 1);
        }
        child.first_source = s[o];
        child.end_source = s[o + 1];
        child.first_target = t[o];
        child.end_target = t[o + 1];
        tree.boxes[static_cast<std::size_t>(b)].child[o] = static_cast<int>(tree.boxes.size());
        tree.boxes.push_back(child);
      }
    }
    if (static_cast<int>(tree.boxes.size()) == end) break;
    tree.level_begin.push_back(static_cast<int>(tree.boxes.size()));
  }
  return tree;
}

}  // namespace kappamu::forward::boundary_integral
