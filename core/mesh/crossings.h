// Where triangles of a mesh cross each other, and how often a ray crosses a mesh: what tells bodies
// from voids and self-intersections that matter from those that do not.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/mesh/box_tree.h"
#include "core/mesh/triangle_mesh.h"

namespace kappamu {

class MeshCrossings {
 public:
  /// The mesh must outlive this.
  explicit MeshCrossings(const TriangleMesh& mesh);

  /// Triangles that cross another one without sharing an edge with it, or lie upon it (of two
  /// components: within 1e-6 of the box). Touching does not count.
  struct Pairs {
    std::uint64_t count = 0;
    std::optional<std::pair<int, int>> first;    ///< with the smallest numbers
    std::optional<std::pair<int, int>> between;  ///< likewise, of two components
    bool all = true;  ///< false: too many triangles lie in each other's boxes to look at every pair
  };
  /// `component`: of each triangle.
  Pairs crossing_pairs(const std::vector<int>& component) const;

  /// Share of the surface that does not have the body on one side and nothing on the other, by the
  /// winding number outside of 4096 points spread evenly over it.
  double hidden_share() const;

  /// Crossings of the ray with triangles that `counts(triangle)`: those from inside (with the
  /// normal) less those from outside, and their number.
  struct Crossings {
    int winding = 0, number = 0;
  };
  template <class Counts>
  Crossings along(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                  const Counts& counts) const {
    Crossings found;
    tree_.visit([&](const Eigen::AlignedBox3d& box) { return meets(box, origin, direction); },
                [&](int triangle) {
                  const int side = crosses(triangle, origin, direction);
                  if (side == 0 || !counts(triangle)) return;
                  found.winding += side;
                  ++found.number;
                });
    return found;
  }

 private:
  static bool meets(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& origin,
                    const Eigen::Vector3d& direction);
  /// 1: leaves through the triangle, -1: enters, 0: passes it.
  int crosses(int triangle, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
  const Eigen::Vector3d& corner(int triangle, int k) const;
  bool triangles_cross(int one, int other, bool between) const;

  const TriangleMesh& mesh_;
  std::vector<Eigen::AlignedBox3d> boxes_;
  BoxTree tree_;
  double length_ = 0.0;  ///< of the box's longest edge
};

}  // namespace kappamu
