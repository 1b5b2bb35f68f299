#include "io/mesh_file.h"

#include <algorithm>

#include "core/error.h"
#include "core/file_name.h"
#include "io/mesh/mesh_formats.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

std::string FileMesh::where(int triangle) const {
  std::string text = face_word + " " + std::to_string(face.at(static_cast<std::size_t>(triangle)));
  const auto after = std::find_if(parts.begin(), parts.end(),
                                  [&](const Part& part) { return part.first_triangle > triangle; });
  if (after != parts.begin()) text += ", " + std::prev(after)->name;
  return text;
}

bool is_mesh_file(const fs::path& file) {
  const std::string ending = lower_extension(file);
  const auto is = [&](const char* known) { return ending == known; };
  return is(".obj") || is(".ply") || is(".stl") || is(".gltf") || is(".glb");
}

FileMesh read_mesh(const fs::path& file, std::span<const double> morph) {
  const std::string name = file.string(), ending = lower_extension(file);
  const auto is = [&](const char* known) { return ending == known; };
  if (!is_mesh_file(file)) {
    throw InputError(name + ": is no mesh file by its name; give .obj, .ply, .stl, .gltf or .glb");
  }
  if (!morph.empty() && !is(".gltf") && !is(".glb")) {
    throw InputError(name + ": a mesh file of this kind has no morph targets; give .gltf or .glb");
  }
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (!error && size > most_mesh_bytes) {
    throw InputError(name + ": has " + std::to_string(size) + " bytes; at most " +
                     std::to_string(most_mesh_bytes) + " are taken, decimate the mesh");
  }
  const std::vector<std::byte> bytes = read_bytes(file);
  if (is(".obj")) return read_obj(bytes, name);
  if (is(".ply")) return read_ply(bytes, name);
  if (is(".stl")) return read_stl(bytes, name);
  return read_gltf(bytes, file, morph);
}

CheckedMesh read_body(const fs::path& file, std::span<const double> morph) {
  const FileMesh read = read_mesh(file, morph);
  CheckedMesh body =
      check_mesh(read.mesh, file.string(), [&](int triangle) { return read.where(triangle); });
  body.warnings.insert(body.warnings.begin(), read.notes.begin(), read.notes.end());
  return body;
}

}  // namespace kappamu::io
