// Triangle meshes from files: OBJ, PLY, STL, glTF (.gltf, .glb), by assimp.
#pragma once

#include <cstddef>
#include <filesystem>

#include "core/mesh/triangle_mesh.h"

namespace kappamu::io {

/// Larger files are refused unread. What a file declares is checked against its size and the limits
/// (core/mesh/mesh_check.h) before anything is allocated for it.
inline constexpr std::size_t most_mesh_bytes = 512'000'000;
inline constexpr std::size_t most_polygon_corners = 256;

/// The surface as the file has it, in its own unit: all meshes of all nodes, placed as the nodes
/// say; polygons as triangles; normals, colours, textures and materials left out. Vertices may be
/// repeated: check_mesh() makes a body of it. Reads no file but this one and, for .gltf, the
/// buffers it names in the same folder. Throws InputError naming the file and what is wrong.
TriangleMesh read_mesh(const std::filesystem::path& file);

}  // namespace kappamu::io
