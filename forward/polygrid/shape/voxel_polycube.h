// A polycube of an object's topology, found by voxels.
#pragma once

#include <optional>

#include "core/mesh/polycube.h"
#include "core/mesh/triangle_mesh.h"

namespace kappamu::forward {

/// Cells of edge `spacing` [mm] that lie in the closed mesh by half or more, the axes those of the
/// mesh, mended to a valid polycube (core/mesh/polycube.h) of the genus `wanted`; nothing where the
/// object's topology does not show at this spacing. Of eight places of the lattice the one is taken
/// at which cells and object differ least.
std::optional<Polycube> voxel_polycube(const TriangleMesh& mesh, double spacing, int wanted);

}  // namespace kappamu::forward
