// Triangles too thin for integrals over them.
#pragma once

#include "core/mesh/triangle_mesh.h"

namespace kappamu::forward::boundary_integral {

/// A triangle's height over its longest edge, at least.
inline constexpr double thinnest_triangle = 1e-4;

/// Throws InputError where a triangle is thinner.
void refuse_slivers(const TriangleMesh& mesh);

}  // namespace kappamu::forward::boundary_integral
