// What a mesh must be for integrals over it to stand for the light inside.
#pragma once

#include "core/mesh/triangle_mesh.h"

namespace kappamu::forward::boundary_integral {

/// A triangle's height over its longest edge, at least.
inline constexpr double thinnest_triangle = 1e-4;

/// Throws InputError unless every edge is run through as often one way as the other (else the mesh
/// is open or a triangle is flipped) and no triangle is thinner than the above.
void check_closed(const TriangleMesh& mesh);

}  // namespace kappamu::forward::boundary_integral
