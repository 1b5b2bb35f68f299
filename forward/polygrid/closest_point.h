// The point of a triangle mesh that is closest to a given one.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh/box_tree.h"
#include "core/mesh/triangle_mesh.h"

namespace kappamu::forward {

/// Of the triangle a b c, by its barycentric weights (Ericson 2005, Real-Time Collision Detection,
/// 5.1.5).
Eigen::Vector3d closest_weights(const Eigen::Vector3d& point, const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b, const Eigen::Vector3d& c);

class ClosestPoint {
 public:
  /// The mesh must outlive this and have a triangle.
  explicit ClosestPoint(const TriangleMesh& mesh);

  struct Found {
    int triangle = 0;                        ///< the first of those that are equally close
    Eigen::Vector3d weights{1.0, 0.0, 0.0};  ///< barycentric
    Eigen::Vector3d point{0.0, 0.0, 0.0};    ///< [mm]
    double distance = 0.0;                   ///< [mm]
  };
  /// `near`: a triangle that may be close, to look at first; the answer does not depend on it
  /// where it is farther than `enough` [mm], at which the search ends.
  Found from(const Eigen::Vector3d& point, int near = 0, double enough = 0.0) const;

  /// Outward, of unit length, interpolated between those of the triangle's corners.
  Eigen::Vector3d smooth_normal(const Found& found) const;
  /// Outward, of unit length, of the triangle.
  const Eigen::Vector3d& normal(int triangle) const;

 private:
  const TriangleMesh& mesh_;
  BoxTree tree_;
  std::vector<std::array<Eigen::Vector3d, 3>> corners_;  ///< of triangles
  std::vector<Eigen::Vector3d> normal_;                  ///< of triangles
  std::vector<Eigen::Vector3d> vertex_normal_;  ///< means of the triangles', weighted by angle
};

}  // namespace kappamu::forward
