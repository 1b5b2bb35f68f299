// A glTF file with nothing in it but what places triangles.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "io/mesh/mesh_claims.h"

namespace kappamu::io {

struct GltfGeometry {
  MeshClaims claims;
  std::vector<std::byte> file;  ///< of the same format, for a library to read
};

/// glTF 2.0: scenes, nodes and their transforms, meshes' positions and indices, the accessors,
/// views and buffers of these, each checked to lie within the next. The rest (normals, colours,
/// textures, skins, morph targets, animations, cameras, extras) is left out before a library reads
/// it: assimp 5.2 writes out of bounds where their counts disagree. `format` is gltf or glb. Throws
/// InputError, which `name` begins.
GltfGeometry gltf_geometry(const std::vector<std::byte>& file, const std::string& format,
                           const std::string& name);

}  // namespace kappamu::io
