// One reader for each kind of mesh file. `name` begins every sentence. Throws InputError.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "io/mesh_file.h"

namespace kappamu::io {

/// `v` and `f`, with or without texture coordinates and normals; objects and groups are parts.
FileMesh read_obj(std::span<const std::byte> file, const std::string& name);

/// Text, or binary of either order: elements `vertex` and `face`, of any types, among any others.
FileMesh read_ply(std::span<const std::byte> file, const std::string& name);

/// Text or binary; each solid is a part.
FileMesh read_stl(std::span<const std::byte> file, const std::string& name);

/// glTF 2.0, as text or binary whatever its name says: its scene's nodes and their transforms,
/// meshes' positions and indices. Buffers lie in the file, in data URIs, or beside `path`.
/// `morph` as read_mesh() takes it.
FileMesh read_gltf(std::span<const std::byte> file, const std::filesystem::path& path,
                   std::span<const double> morph);

}  // namespace kappamu::io
