// An octree about a closed triangle mesh: which cubes the surface passes through, refined where the
// solver asks, at most one level apart between cubes that touch (2:1).
//
// The root is a cube somewhat larger than the mesh, its corner at an offset of no simple fraction,
// so that faces of axis-parallel objects do not lie in faces of cubes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "forward/embedded/geometry/triangle_clip.h"

namespace kappamu::forward::embedded {

/// The cube of edge 2^−level at `at`·2^−level, in units of the root's edge.
struct Cube {
  int level = 0;
  std::array<std::uint32_t, 3> at{};
};

/// Deepest level a cube may have.
inline constexpr int deepest_level = 16;

class Octree {
 public:
  explicit Octree(const TriangleMesh& mesh);

  /// Splits until no cube above `level` meets the surface, then balances.
  void refine_surface(int level);
  /// Splits each of the leaves `nodes` so many `times`, of one that meets the surface only what
  /// meets it more than once, and balances.
  void refine(const std::vector<int>& nodes, const std::vector<int>& times);
  /// Splits the leaves `nodes` once each and nothing else: 2:1 holds between their children.
  void refine_each(const std::vector<int>& nodes);

  /// Leaves in Morton order.
  std::vector<int> leaves() const;
  std::size_t node_count() const { return nodes_.size(); }
  const Cube& cube(int node) const { return nodes_[static_cast<std::size_t>(node)].cube; }
  bool is_leaf(int node) const { return nodes_[static_cast<std::size_t>(node)].child < 0; }
  /// First of the eight children; x varies fastest.
  int first_child(int node) const { return nodes_[static_cast<std::size_t>(node)].child; }
  int parent(int node) const { return nodes_[static_cast<std::size_t>(node)].parent; }
  bool meets_surface(int node) const { return nodes_[static_cast<std::size_t>(node)].count > 0; }
  /// The smallest node that contains the cube; none where it lies outside the root.
  int containing(int level, const std::array<std::int64_t, 3>& at) const;
  /// The leaf that contains a point of root units in [0, 1)³; found soonest from a node close by.
  int leaf_at(const Eigen::Vector3d& point, int near = 0) const;

  /// Calls visit(triangle index, triangle in units of the root) for those that meet the cube.
  template <class Visit>
  void for_triangles(int node, const Visit& visit) const {
    const Node& n = nodes_[static_cast<std::size_t>(node)];
    for (std::size_t k = n.first; k < n.first + n.count; ++k) {
      visit(list_[k], triangles_[static_cast<std::size_t>(list_[k])]);
    }
  }

  double edge_mm() const { return edge_mm_; }  ///< of the root
  Eigen::Vector3d to_root(const Eigen::Vector3d& point_mm) const {
    return (point_mm - origin_) / edge_mm_;
  }
  Eigen::Vector3d to_mm(const Eigen::Vector3d& point) const { return origin_ + edge_mm_ * point; }

 private:
  struct Node {
    Cube cube;
    int parent = -1, child = -1;
    std::size_t first = 0, count = 0;  ///< of list_: the triangles that meet the cube
  };
  void split(int node);
  void balance();

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();  ///< [mm]
  double edge_mm_ = 1.0;
  std::vector<Triangle> triangles_;  ///< in units of the root
  std::vector<Node> nodes_;
  std::vector<int> list_;
};

}  // namespace kappamu::forward::embedded
