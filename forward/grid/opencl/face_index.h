// Where the samples of a face lie in the device's arrays, as affine indices (grid_surface.cl).
#pragma once

#include <array>

#include "core/grid.h"

namespace kappamu::forward {

/// Sample (u, v) of a face touches cell `cell + u cell_u + v cell_v`.
struct FaceIndex {
  int nu, nv, cell, cell_u, cell_v;
};
FaceIndex face_index(const GridShape& shape, Face face);

/// From a voxel to the next one below the face.
int cells_inwards(const GridShape& shape, Face face);

/// The column below the lit face in which voxel (x, y, z) lies: x a[0] + y a[1] + z a[2].
std::array<int, 3> column_strides(const GridShape& shape, Face lit);

}  // namespace kappamu::forward
