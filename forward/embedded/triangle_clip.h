// A triangle against a cube of the octree: whether they meet, and the part inside.
#pragma once

#include <Eigen/Core>
#include <array>

namespace kappamu::forward::embedded {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// Whether the triangle meets the cube of half edge `half` about `centre` (separating axes).
bool meets_cube(const Triangle& triangle, const Eigen::Vector3d& centre, double half);

/// A convex polygon, at most a triangle cut by six planes.
struct Polygon {
  std::array<Eigen::Vector3d, 12> vertex;
  int size = 0;
};

/// The part of a triangle inside the unit cube. Vertices made on a face of the cube have that
/// coordinate exactly. A triangle that lies in the face between two cubes belongs to the lower one.
Polygon clipped_to_unit_cube(const Triangle& triangle);

}  // namespace kappamu::forward::embedded
