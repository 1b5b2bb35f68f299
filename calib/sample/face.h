// A face of the block in space and as an upright camera sees it (docs/conventions.md).
#pragma once

#include <Eigen/Core>
#include <array>

#include "core/grid.h"

namespace kappamu::calib {

/// Corners (u, v) = (0,0), (max,0), (max,max), (0,max) of the face's array, in the sample frame
/// [mm].
std::array<Eigen::Vector3d, 4> face_corners(const GridShape& grid, Face face);

/// Point of the face at (u, v) in voxels, (0, 0) at the first corner, voxel (i, j) covering
/// [i, i+1] x [j, j+1]; sample frame [mm].
Eigen::Vector3d face_point(const GridShape& grid, Face face, double u, double v);

/// Unit outward normal in the sample frame.
Eigen::Vector3d face_normal(Face face);

/// Whether a camera that looks at the face upright (v down) sees u run to the left, as on z+.
bool seen_mirrored(Face face);

/// Puts corners listed clockwise in the picture from the top left one into the order of
/// face_corners.
std::array<Eigen::Vector2d, 4> from_clockwise(Face face,
                                              const std::array<Eigen::Vector2d, 4>& clockwise);

}  // namespace kappamu::calib
