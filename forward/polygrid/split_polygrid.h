// Polygrids from cells and their corners, and the same with every cell split in eight.
#pragma once

#include "core/mesh/triangle_mesh.h"
#include "forward/polygrid/polygrid.h"

namespace kappamu::forward::polygrid {

/// Links cells that share four corners, and gives every other side a boundary node at its middle.
/// Cells are put in the order of their places, corners in that of the cells; interior nodes lie at
/// the middle of their cells. `cell`, `cell_corners` and `corner` as in Polygrid.
Polygrid linked(std::vector<Eigen::Vector3i> cell, std::vector<std::array<int, 8>> cell_corners,
                std::vector<Eigen::Vector3d> corner);

/// Every cell's map on eight cells. New corners on the boundary are moved to the nearest point of
/// the mesh, unless that turns a cell inside out. A layer on the boundary becomes two cells thick:
/// the equations do not mind.
Polygrid split(const Polygrid& grid, const TriangleMesh& mesh);

}  // namespace kappamu::forward::polygrid
