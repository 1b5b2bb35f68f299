// A polygrid: the interior of a closed mesh as the deformed cells of a polycube ([W] 5.1, figure
// 4).
//
// Each cell is an interior node with six links; a boundary node is a face on the object's surface,
// linked to exactly one interior node. The core is a set of cells of the integer lattice. Around it
// lies one layer: a cell upon each face of the core's surface, at the lattice place beyond that
// face, whose outer side is the boundary node. This is the corner and edge rule of [W] figure 4 (g,
// h) without exceptions: where the core's surface bends, two cells of the layer are neighbours
// around the edge, so every node has six links and none has two boundary nodes. Two consequences at
// such edges:
//   - the link back is not the opposite side: if link[i][s] = j ≥ 0, then link[j][t] = i for
//   exactly
//     one t, which is s ^ 1 everywhere but between two cells of the layer;
//   - at a concave edge two or three cells of the layer have the same place, with different outer
//   sides.
// A set of lattice cells without such a layer (a block) is also a polygrid; its edge cells have two
// or three boundary nodes.
//
// The map into the object is given at the corners and is trilinear within a cell; faces between
// cells are those of their four corners, the same four from both sides, so that neighbours meet
// without gap or overlap.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace kappamu::forward {

struct Polygrid {
  /// Place of each interior node, sorted (z slowest, x fastest, then by the side of the boundary).
  /// Halving the places of a polygrid whose core is made of blocks of 2³ gives those of the coarser
  /// one, layer included: cells join where place >> 1 and the outer side, if any, agree.
  std::vector<Eigen::Vector3i> cell;
  /// Corners of each cell, bit 0 of the place in x, bit 1 in y, bit 2 in z: indices into `corner`.
  std::vector<std::array<int, 8>> cell_corners;
  /// Neighbour of each interior node towards its own -x, +x, -y, +y, -z, +z: the index of an
  /// interior node where it is not negative, else ~index of the boundary node of that face.
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
