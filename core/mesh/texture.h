// Texture coordinates of a mesh whose triangles were mended.
#pragma once

#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace kappamu {

/// Texture coordinates of `mesh`, whose triangle t was made of triangle source[t] of `given`: those
/// of the given triangle's plane at each corner, so that corners may be welded, turned or moved.
/// Empty where `given` has none.
std::vector<CornerTexture> texture_from(const TriangleMesh& given, const TriangleMesh& mesh,
                                        const std::vector<int>& source);

}  // namespace kappamu
