// The part of an octree inside a closed triangle mesh: whole cubes, cut cubes with their exact
// moments, and the pieces of the surface in them.
#pragma once

#include <cmath>
#include <vector>

#include "core/ray_caster.h"
#include "forward/embedded/geometry/cut_cell.h"
#include "forward/embedded/geometry/octree.h"

namespace kappamu::forward::embedded {

struct CutMesh {
  /// Part of a triangle in a cube; weight[i] = ∫ N_i dA of the cube's shape functions [mm²].
  struct Piece {
    int triangle = 0, cube = 0;
    std::array<float, 8> weight{};
  };

  double edge_mm = 1.0;     ///< of the root
  std::vector<Cube> cubes;  ///< inside or cut, Morton order
  std::vector<int> leaf;    ///< of the octree, per cube
  std::vector<int> cut;     ///< place in `volume` and `surface`, −1 where the cube is whole
  std::vector<Moments> volume, surface;
  std::vector<Piece> pieces;      ///< by cube
  std::vector<int> cube_of_leaf;  ///< per node of the octree; −1 outside

  double h(std::size_t cube) const { return std::ldexp(edge_mm, -cubes[cube].level); }
  /// Share of the cube inside the object.
  double fraction(std::size_t cube) const {
    return cut[cube] < 0 ? 1.0 : volume[static_cast<std::size_t>(cut[cube])][0];
  }
};

/// Leaves of the octree that the surface may pass through, and those inside.
std::vector<int> object_leaves(const Octree& tree, const TriangleMesh& mesh, const RayCaster& rays);

/// Rays decide only what the surface inside the cubes leaves open: one per connected region of
/// cubes without surface.
CutMesh cut_mesh(const Octree& tree, const TriangleMesh& mesh, const RayCaster& rays);

}  // namespace kappamu::forward::embedded
