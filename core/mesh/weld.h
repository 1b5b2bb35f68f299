// Which vertices of a mesh are one: per vertex, the number of the vertex it becomes.
#pragma once

#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace kappamu {

/// Of exactly the same position.
std::vector<int> equal_vertices(const TriangleMesh& mesh);

/// The ends of edges up to `distance` [mm] long of triangles with less area than its square.
std::vector<int> ends_of_needles(const TriangleMesh& mesh, double distance);

/// Of open edges, up to `distance` [mm] apart.
std::vector<int> gaps_of_edges(const TriangleMesh& mesh, double distance);

}  // namespace kappamu
