#include "forward/boundary_integral/panels/panel.h"

#include <algorithm>

namespace kappamu::forward::boundary_integral {

Panel make_panel(const std::array<Eigen::Vector3d, 3>& corner, int sample) {
  Panel panel;
  panel.corner = corner;
  panel.centre = (corner[0] + corner[1] + corner[2]) / 3.0;
  const Eigen::Vector3d doubled = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  panel.normal = doubled.normalized();
  panel.area = 0.5 * doubled.norm();
  for (const Eigen::Vector3d& c : corner) {
    panel.radius = std::max(panel.radius, (c - panel.centre).norm());
  }
  panel.sample = sample;
  return panel;
}

std::vector<Panel> panels_of(const TriangleMesh& mesh) {
  std::vector<Panel> panels;
  panels.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto vertex = [&](std::size_t k) {
      return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][k])];
    };
    panels.push_back(make_panel({vertex(0), vertex(1), vertex(2)}, static_cast<int>(t)));
  }
  return panels;
}

std::array<Panel, 4> split(const Panel& panel) {
  const auto& [a, b, c] = panel.corner;
  const Eigen::Vector3d ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
  return {make_panel({a, ab, ca}, panel.sample), make_panel({ab, b, bc}, panel.sample),
          make_panel({ca, bc, c}, panel.sample), make_panel({ab, bc, ca}, panel.sample)};
}

std::array<Eigen::Vector3d, 3> rule_points(const Panel& panel) {
  std::array<Eigen::Vector3d, 3> points;
  for (std::size_t k = 0; k < 3; ++k) points[k] = 0.5 * (panel.corner[k] + panel.centre);
  return points;
}

}  // namespace kappamu::forward::boundary_integral
