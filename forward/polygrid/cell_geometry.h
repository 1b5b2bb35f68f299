// Geometry of a polygrid's cells and of the faces on the object's surface.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>

#include "core/mesh/triangle_mesh.h"
#include "forward/polygrid/polygrid.h"

namespace kappamu::forward {

/// Corners of a cell (by their bits) on its side, counter-clockwise seen from outside.
std::array<int, 4> side_corners(int side);

/// Corners of a boundary side: indices into Polygrid::corner, in the order of side_corners().
std::array<int, 4> boundary_corners(const Polygrid& grid, std::size_t boundary_side);

/// Corners of a cell as Polygrid::cell_corners has them [mm].
using CellCorners = std::array<Eigen::Vector3d, 8>;
CellCorners corners_of(const Polygrid& grid, std::size_t cell);

/// Mean of a side's four corners [mm].
Eigen::Vector3d side_centre(const Polygrid& grid, std::size_t cell, int side);

/// Of the bilinear face, outward [mm²].
Eigen::Vector3d side_area(const Polygrid& grid, std::size_t cell, int side);

/// The cell's point at `u`, each from 0 to 1 along its axes [mm].
Eigen::Vector3d within_cell(const Polygrid& grid, std::size_t cell, const Eigen::Vector3d& u);

/// Where in the cell a point lies, as within_cell() takes it; nothing where it lies outside.
std::optional<Eigen::Vector3d> place_in_cell(const Polygrid& grid, std::size_t cell,
                                             const Eigen::Vector3d& point);

/// Of the cell bounded by bilinear faces [mm³].
double cell_volume(const Polygrid& grid, std::size_t cell);

/// Least of the eight corners: determinant of the three edges there, each over its length.
double scaled_jacobian(const Polygrid& grid, std::size_t cell);

/// Triangles 2k and 2k + 1 are the face of boundary node k. Vertices are the grid's corners, unused
/// ones included.
TriangleMesh surface_of_grid(const Polygrid& grid);

}  // namespace kappamu::forward
