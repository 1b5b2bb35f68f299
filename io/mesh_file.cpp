#include "io/mesh_file.h"

#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file_name.h"
#include "core/mesh/mesh_check.h"
#include "io/mesh/gltf_geometry.h"
#include "io/mesh/mesh_claims.h"
#include "io/read_file.h"

namespace Assimp {
// Debian builds assimp with its assertions, which end the program on some damaged files. This takes
// the place of the library's own function of that name: here they end the reading.
void aiAssertViolation(const char* failed, const char* file, int line);
void aiAssertViolation(const char* failed, const char* /*file*/, int /*line*/) {
  throw std::runtime_error(failed);
}
}  // namespace Assimp

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

std::vector<std::byte> read_bounded(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (!error && size > most_mesh_bytes) {
    throw InputError(file.string() + ": has " + std::to_string(size) + " bytes; at most " +
                     std::to_string(most_mesh_bytes) + " are taken, decimate the mesh");
  }
  return read_bytes(file);
}

/// What assimp may open: the mesh, already in memory, and buffers beside it.
class FolderFiles final : public Assimp::IOSystem {
 public:
  FolderFiles(const fs::path& file, std::vector<std::byte> bytes)
      : file_(file), bytes_(std::move(bytes)) {}

  bool Exists(const char* name) const override { return name == file_.string() || is_buffer(name); }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* /*mode*/) override {
    if (name == file_.string()) return stream(bytes_);
    if (!is_buffer(name)) return nullptr;
    try {
      return stream(buffers_.emplace_back(read_bounded(name)));
    } catch (const InputError&) {
      return nullptr;
    }
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  static Assimp::IOStream* stream(const std::vector<std::byte>& bytes) {
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                      bytes.size());
  }
  bool is_buffer(const fs::path& name) const {
    return file_.extension() == ".gltf" && name.extension() == ".bin" &&
           name.parent_path() == file_.parent_path() && fs::is_regular_file(name);
  }

  fs::path file_;
  std::vector<std::byte> bytes_;
  std::vector<std::vector<std::byte>> buffers_;
};

std::string format_of(const fs::path& file) {
  const std::string ending = lower_extension(file);
  for (const char* known : {"obj", "ply", "stl", "gltf", "glb"}) {
    if (ending == std::string(".") + known) return known;
  }
  throw InputError(file.string() +
                   ": is no mesh file by its name; give .obj, .ply, .stl, .gltf or .glb");
}

void check_count(const std::string& name, std::size_t triangles, std::size_t vertices) {
  if (triangles <= most_triangles && vertices <= 3 * most_triangles) return;
  throw InputError(name + ": has " + std::to_string(triangles) + " triangles and " +
                   std::to_string(vertices) + " vertices; at most " +
                   std::to_string(most_triangles) + " triangles are taken, decimate the mesh");
}

/// Polygons before they are cut into triangles, which takes long for many corners. Puts right what
/// importers say of a mesh's kinds of faces, since assimp's triangulation relies on it.
void check_polygons(const std::string& name, const aiScene& scene) {
  std::size_t triangles = 0, vertices = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    aiMesh& mesh = *scene.mMeshes[m];
    mesh.mPrimitiveTypes = 0;
    vertices += mesh.mNumVertices;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const unsigned corners = mesh.mFaces[f].mNumIndices;
      if (corners > most_polygon_corners) {
        throw InputError(name + ": polygon " + std::to_string(f) + " has " +
                         std::to_string(corners) + " corners; at most " +
                         std::to_string(most_polygon_corners) + " are taken, triangulate the mesh");
      }
      // Triangles may have one: check_mesh() names it.
      for (unsigned k = 0; corners > 3 && k < corners; ++k) {
        if (mesh.mFaces[f].mIndices[k] < mesh.mNumVertices) continue;
        throw InputError(name + ": polygon " + std::to_string(f) + " names vertex " +
                         std::to_string(mesh.mFaces[f].mIndices[k]) + ", and there are " +
                         std::to_string(mesh.mNumVertices) + "; export it again");
      }
      triangles += corners < 3 ? 0 : corners - 2;
      mesh.mPrimitiveTypes |= AI_PRIMITIVE_TYPE_FOR_N_INDICES(std::max(corners, 1U));
    }
  }
  check_count(name, triangles, vertices);
}

void append(const aiMesh& part, const aiMatrix4x4& placed, TriangleMesh& mesh) {
  const int first = static_cast<int>(mesh.vertices.size());
  for (unsigned v = 0; v < part.mNumVertices; ++v) {
    const aiVector3D vertex = placed * part.mVertices[v];
    mesh.vertices.emplace_back(vertex.x, vertex.y, vertex.z);
  }
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices != 3) continue;  // points and lines
    std::array<int, 3> triangle{};
    for (unsigned k = 0; k < 3; ++k) {
      triangle[k] = face.mIndices[k] < part.mNumVertices
                        ? first + static_cast<int>(face.mIndices[k])
                        : -1;  // check_mesh() names it
    }
    mesh.triangles.push_back(triangle);
  }
}

}  // namespace

TriangleMesh read_mesh(const fs::path& file) {
  const std::string name = file.string(), format = format_of(file);
  std::vector<std::byte> bytes = read_bounded(file);
  MeshClaims claims;
  if (format == "gltf" || format == "glb") {
    GltfGeometry geometry = gltf_geometry(bytes, format, name);
    claims = geometry.claims;
    bytes = std::move(geometry.file);
  } else {
    claims = mesh_claims(bytes, format, name);
  }
  check_count(name, claims.triangles, claims.vertices);

  Assimp::Importer importer;
  importer.SetIOHandler(new FolderFiles(file, std::move(bytes)));  // the importer owns it
  importer.SetPropertyInteger(
      AI_CONFIG_PP_RVC_FLAGS,
      aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
          aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
          aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS | aiComponent_MATERIALS);
  const auto unreadable = [&](std::string why) {
    why = why.substr(0, std::min(why.find('\n'), std::size_t{160}));
    return InputError(name + ": cannot be read as a mesh (" + why + "); export it again");
  };
  const aiScene* scene = nullptr;
  try {
    scene = importer.ReadFile(name, aiProcess_RemoveComponent);
    if (scene != nullptr && scene->mRootNode != nullptr) {
      check_polygons(name, *scene);
      scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
    }
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    throw unreadable(error.what());
  }
  if (scene == nullptr || scene->mRootNode == nullptr) throw unreadable(importer.GetErrorString());

  TriangleMesh mesh;
  std::vector<std::pair<const aiNode*, aiMatrix4x4>> nodes{{scene->mRootNode, aiMatrix4x4()}};
  while (!nodes.empty()) {
    const auto [node, parent] = nodes.back();
    nodes.pop_back();
    const aiMatrix4x4 placed = parent * node->mTransformation;
    for (unsigned m = 0; m < node->mNumMeshes; ++m) {
      const aiMesh& part = *scene->mMeshes[node->mMeshes[m]];
      check_count(name, mesh.triangles.size() + part.mNumFaces,
                  mesh.vertices.size() + part.mNumVertices);
      append(part, placed, mesh);
    }
    for (unsigned c = 0; c < node->mNumChildren; ++c)
      nodes.emplace_back(node->mChildren[c], placed);
  }
  if (mesh.triangles.empty()) {
    throw InputError(name + ": has no triangles; give a closed triangle mesh");
  }
  return mesh;
}

}  // namespace kappamu::io
