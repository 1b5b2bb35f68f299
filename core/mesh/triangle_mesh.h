// Closed triangle meshes in the object's frame, lengths in mm, and the surface samples made of
// them.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace kappamu {

struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;      ///< [mm]
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// Samples of an object's surface: light is given on them and exitance is returned on them. For a
/// mesh there is one sample per triangle, in the mesh's order.
struct Surface {
  std::vector<Eigen::Vector3d> position;  ///< centroid [mm]
  std::vector<Eigen::Vector3d> normal;    ///< outward, of unit length
  std::vector<double> area;               ///< [mm²]

  std::size_t size() const { return position.size(); }
};

Surface surface_of(const TriangleMesh& mesh);

/// Volume enclosed by a closed mesh, positive where the triangles are oriented outwards [mm³].
double enclosed_volume(const TriangleMesh& mesh);

Eigen::AlignedBox3d bounding_box(const TriangleMesh& mesh);

}  // namespace kappamu
