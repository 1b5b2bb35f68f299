// Triangle meshes from files: OBJ, PLY, STL, glTF (.gltf, .glb).
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/mesh_check.h"
#include "core/mesh/triangle_mesh.h"

namespace kappamu::io {

/// Larger files are refused unread. What a file declares is checked against its size and the limits
/// (core/mesh/mesh_check.h) before anything is allocated for it.
inline constexpr std::size_t most_mesh_bytes = 512'000'000;
inline constexpr std::size_t most_polygon_corners = 256;

/// The surface as a file has it, in its own unit and at its own place, and the file's names of what
/// is in it.
struct FileMesh {
  TriangleMesh mesh;
  /// Per triangle the face it is of: the line of a text (from 1), or its number (from 0).
  std::vector<int> face;
  std::string face_word;  ///< "line", "face" or "triangle"
  struct Part {
    int first_triangle = 0;
    std::string name;  ///< "object 'lid'"
  };
  std::vector<Part> parts;         ///< in the order of their triangles
  std::vector<std::string> notes;  ///< sentences: what of the file was left out

  /// "line 31, object 'lid'".
  std::string where(int triangle) const;
};

/// By its ending.
bool is_mesh_file(const std::filesystem::path& file);

/// All meshes of all nodes, placed as the nodes say; polygons as triangles, with the first set of
/// texture coordinates (of a PLY file, its vertices') where all faces have one; normals, colours,
/// images, materials, skins and morph targets left out, these but for the weights `morph`, one for
/// each target of every primitive. Vertices may be repeated. Reads no file
/// but this one and, for glTF, the buffers it names in the same folder or below. Throws InputError
/// naming the file, the place in it and what is wrong.
FileMesh read_mesh(const std::filesystem::path& file, std::span<const double> morph = {});

/// The body that a file's surface bounds: read_mesh(), then check_mesh() with the file's own names.
CheckedMesh read_body(const std::filesystem::path& file, std::span<const double> morph = {});

}  // namespace kappamu::io
