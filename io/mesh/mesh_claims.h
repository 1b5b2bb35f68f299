// What a mesh file declares it holds, before a library believes it.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace kappamu::io {

/// Triangles and vertices that the file's text or header speaks of, polygons counted as triangles
/// where the text shows them. `format` is the ending in lower case: obj, ply or stl.
struct MeshClaims {
  std::size_t triangles = 0, vertices = 0;
};

/// Throws InputError, which `name` begins, where a declared size is more than the file holds, or
/// the header cannot be read.
MeshClaims mesh_claims(std::span<const std::byte> file, const std::string& format,
                       const std::string& name);

}  // namespace kappamu::io
