// Closed triangle meshes in the object's frame, lengths in mm, and the surface samples made of
// them.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace kappamu {

/// Texture coordinates u, v of a triangle's three corners [dimensionless]: seams give a vertex
/// several, so they belong to corners.
using CornerTexture = std::array<Eigen::Vector2f, 3>;

struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;      ///< [mm]
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside
  std::vector<CornerTexture> texture;         ///< per triangle; empty where the mesh has none
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
