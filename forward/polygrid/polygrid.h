// A polygrid: the interior of a closed mesh as the deformed cells of a polycube ([W] 5.1, figure 4).
//
// The polycube is a set of cells of the integer lattice. Each is an interior node; each of its faces that
// no other cell shares is a boundary node, linked to exactly that one interior node ([W] figure 4 g, h:
// nodes on edges and corners of a cube would have none or several, and are left out). The map into the
// object is given at the lattice's corners and is trilinear within a cell; faces between cells are those
// of their four corners, so that neighbours meet without gap or overlap.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace kappamu::forward {

struct Polygrid {
  /// Interior nodes, sorted by lattice place (z slowest, x fastest).
  std::vector<Eigen::Vector3i> cell;
  /// Corners of each cell, bit 0 of the place in x, bit 1 in y, bit 2 in z: indices into `corner`.
  std::vector<std::array<int, 8>> cell_corners;
  /// Neighbour of each interior node towards -x, +x, -y, +y, -z, +z: the index of an interior node where
  /// it is not negative, else ~index of the boundary node of that face.
  std::vector<std::array<int, 6>> link;
  std::vector<Eigen::Vector3d> corner;         ///< mapped positions [mm]
  std::vector<Eigen::Vector3d> node;           ///< of the interior nodes [mm], within their cells
  std::vector<Eigen::Vector3d> boundary_node;  ///< on the object's surface [mm]
  std::vector<Eigen::Vector3d> normal;         ///< outward there, of unit length
  std::vector<double> area;                    ///< of the boundary node's face [mm²]
  std::vector<int> boundary_cell;              ///< the interior node it is linked to
  std::vector<int> boundary_side;              ///< which of that node's six links it is
};

}  // namespace kappamu::forward
