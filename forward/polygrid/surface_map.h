// Between a mesh's surface and the boundary of its polygrid, which lie within a small part of a
// cell of each other: for points of either, the nearest of the other.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "forward/polygrid/polygrid.h"

namespace kappamu::forward::polygrid {

class SurfaceMap {
 public:
  SurfaceMap(const Polygrid& grid, const TriangleMesh& mesh, const Surface& surface);

  /// Means over the triangles of what is given at the corners of the cells and bilinear on the
  /// boundary's sides.
  void on_triangles(std::span<const double> at_corners, std::span<double> means) const;
  std::size_t triangles() const { return side_of_.size(); }
  /// Adds `factor` ∫ f N dA of every corner's function over the boundary [mm² f], of f given per
  /// triangle, and returns the sum of ∫ f N dA.
  double add_loads(std::span<const double> on_triangles, double factor,
                   std::span<double> at_corners) const;
  /// The boundary side nearest to a triangle's middle.
  int side_of(std::size_t triangle) const { return side_of_[triangle]; }
  /// Distance of every triangle's middle from the boundary [mm], 0 where it is less than 0.3 of the
  /// mean length of a side: parts of the mesh that the polygrid leaves out.
  const std::vector<double>& gaps() const { return gaps_; }

 private:
  struct Share {
    int corner = 0;
    double weight = 0.0;  ///< those of a triangle sum to one
  };
  std::vector<std::size_t> first_{0};  ///< of each triangle's shares, and the end of the last
  std::vector<Share> shares_;
  std::vector<int> side_of_;
  std::vector<double> gaps_;
  /// Points of the boundary's sides, four of each.
  struct LitPoint {
    int triangle = 0;
    std::array<int, 4> corner{};
    std::array<double, 4> area{};  ///< weight times the corner's function [mm²]
  };
  std::vector<LitPoint> points_;
};

}  // namespace kappamu::forward::polygrid
