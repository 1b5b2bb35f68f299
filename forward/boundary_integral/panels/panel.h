// Flat triangles that carry a constant fluence each: the mesh's own triangles or parts of them.
// Parts need not match at edges, so that each may be split alone.
#pragma once

#include <array>
#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace kappamu::forward::boundary_integral {

struct Panel {
  std::array<Eigen::Vector3d, 3> corner;  ///< [mm], counter-clockwise seen from outside
  Eigen::Vector3d centre;                 ///< centroid [mm]
  Eigen::Vector3d normal;                 ///< outward, of unit length
  double area = 0.0;                      ///< [mm²]
  double radius = 0.0;                    ///< farthest corner from the centroid [mm]
  int sample = 0;                         ///< triangle of the mesh that it is part of
};

Panel make_panel(const std::array<Eigen::Vector3d, 3>& corner, int sample);
std::vector<Panel> panels_of(const TriangleMesh& mesh);
/// The four panels that halving the edges makes.
std::array<Panel, 4> split(const Panel& panel);

/// Interior points of the rule exact for quadratic functions, each of weight ⅓ of the area.
std::array<Eigen::Vector3d, 3> rule_points(const Panel& panel);
/// Their distance from the centroid, at most, over the panel's radius.
inline constexpr double rule_reach = 0.5;

}  // namespace kappamu::forward::boundary_integral
