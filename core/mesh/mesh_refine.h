// Triangles split until none is long, so that surface samples resolve the light on them.
#pragma once

#include "core/mesh/triangle_mesh.h"

namespace kappamu {

/// The same surface with every edge at most `longest_edge` [mm]: edges are halved, and triangles
/// split at the halves, until all are short. A closed mesh stays closed and keeps its texture
/// coordinates. Throws InputError where this takes more than `limit` triangles.
TriangleMesh refined(const TriangleMesh& mesh, double longest_edge, std::size_t limit);

}  // namespace kappamu
