#include "core/mesh/triangle_mesh.h"

namespace kappamu {

Surface surface_of(const TriangleMesh& mesh) {
  Surface surface;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d& p = mesh.vertices[static_cast<std::size_t>(a)];
    const Eigen::Vector3d& q = mesh.vertices[static_cast<std::size_t>(b)];
    const Eigen::Vector3d& r = mesh.vertices[static_cast<std::size_t>(c)];
    const Eigen::Vector3d doubled = (q - p).cross(r - p);
    surface.position.push_back((p + q + r) / 3.0);
    surface.normal.push_back(doubled.normalized());
    surface.area.push_back(doubled.norm() / 2.0);
  }
  return surface;
}

double enclosed_volume(const TriangleMesh& mesh) {
  double volume = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    volume += mesh.vertices[static_cast<std::size_t>(a)].dot(
        mesh.vertices[static_cast<std::size_t>(b)].cross(
            mesh.vertices[static_cast<std::size_t>(c)]));
  }
  return volume / 6.0;
}

Eigen::AlignedBox3d bounding_box(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

}  // namespace kappamu
