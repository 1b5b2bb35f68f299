// Boxes of triangles in a binary tree, each node split at the median of its longest axis.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <vector>

namespace kappamu {

class BoxTree {
 public:
  explicit BoxTree(const std::vector<Eigen::AlignedBox3d>& boxes) : order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    nodes_.reserve(boxes.size());
    if (!boxes.empty()) build(boxes, 0, static_cast<int>(boxes.size()));
  }

  /// Calls leaf(i) for the boxes of all nodes that `meets(box)`; box i itself is not asked.
  template <class Meets, class Leaf>
  void visit(const Meets& meets, const Leaf& leaf) const {
    if (!nodes_.empty()) visit(0, meets, leaf);
  }

  /// Calls leaf(i) for the boxes of all nodes whose off(box) is not above farthest() by then, of
  /// two children the one of the lesser first.
  template <class Off, class Farthest, class Leaf>
  void visit_nearest(const Off& off, const Farthest& farthest, const Leaf& leaf) const {
    if (!nodes_.empty() && off(nodes_[0].box) <= farthest()) {
      visit_nearest(0, off, farthest, leaf);
    }
  }

 private:
  static constexpr int leaf_size = 4;

  struct Node {
    Eigen::AlignedBox3d box;
    int begin = 0, end = 0;  ///< in order_
    int second = 0;          ///< child beside the next node; 0: a leaf
  };

  void build(const std::vector<Eigen::AlignedBox3d>& boxes, int begin, int end) {
    const std::size_t self = nodes_.size();
    Node node;
    node.begin = begin;
    node.end = end;
    const auto box_of = [&](int i) -> const Eigen::AlignedBox3d& {
      return boxes[static_cast<std::size_t>(i)];
    };
    for (int i = begin; i < end; ++i) node.box.extend(box_of(order_[static_cast<std::size_t>(i)]));
    nodes_.push_back(node);
    if (end - begin <= leaf_size) return;
    int axis = 0;
    node.box.sizes().maxCoeff(&axis);
    const int middle = (begin + end) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](int a, int b) {
                       return box_of(a).min()[axis] + box_of(a).max()[axis] <
                              box_of(b).min()[axis] + box_of(b).max()[axis];
                     });
    build(boxes, begin, middle);
    nodes_[self].second = static_cast<int>(nodes_.size());
    build(boxes, middle, end);
  }

  template <class Meets, class Leaf>
  void visit(int index, const Meets& meets, const Leaf& leaf) const {
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (!meets(node.box)) return;
    if (node.second == 0) {
      for (int i = node.begin; i < node.end; ++i) leaf(order_[static_cast<std::size_t>(i)]);
      return;
    }
    visit(index + 1, meets, leaf);
    visit(node.second, meets, leaf);
  }

  template <class Off, class Farthest, class Leaf>
  void visit_nearest(int index, const Off& off, const Farthest& farthest, const Leaf& leaf) const {
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (node.second == 0) {
      for (int i = node.begin; i < node.end; ++i) leaf(order_[static_cast<std::size_t>(i)]);
      return;
    }
    std::array<int, 2> child{index + 1, node.second};
    std::array<double, 2> away{};
    for (std::size_t k = 0; k < 2; ++k)
      away[k] = off(nodes_[static_cast<std::size_t>(child[k])].box);
    if (away[1] < away[0]) {
      std::swap(child[0], child[1]);
      std::swap(away[0], away[1]);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      if (away[k] <= farthest()) visit_nearest(child[k], off, farthest, leaf);
    }
  }

  std::vector<int> order_;
  std::vector<Node> nodes_;  ///< the root first, each node's first child beside it
};

}  // namespace kappamu
