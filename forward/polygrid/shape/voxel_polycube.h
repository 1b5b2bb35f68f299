// A polycube of an object's topology, found by voxels.
#pragma once

#include <functional>
#include <optional>

#include "core/mesh/polycube.h"
#include "core/mesh/triangle_mesh.h"

namespace kappamu::forward {

/// Cells of edge `spacing` [mm] that lie in the closed mesh by half or more, the axes those of the
/// mesh, mended to a valid polycube (core/mesh/polycube.h) of the genus `wanted`; nothing where the
/// object's topology does not show at this spacing. Of eight places of the lattice the one is taken
/// at which cells and object differ least. `report` is called all along and may throw Cancelled.
std::optional<Polycube> voxel_polycube(const TriangleMesh& mesh, double spacing, int wanted,
                                       const std::function<void()>& report);

}  // namespace kappamu::forward
