// Meshes as files of each kind, for tests of their readers.
#pragma once

#include <gmock/gmock.h>

#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "io/mesh_file.h"
#include "tests/io/support.h"

namespace kappamu::io {

namespace fs = std::filesystem;

inline std::string obj_text(const TriangleMesh& mesh) {
  std::ostringstream out;
  out << "# a comment\nmtllib other.mtl\no thing\n";
  for (const Eigen::Vector3d& v : mesh.vertices)
    out << "v " << v.x() << " " << v.y() << " " << v.z() << "\n";
  out << "vn 0 0 1\nusemtl red\n";
  for (const auto& [a, b, c] : mesh.triangles) {
    out << "f " << a + 1 << "//1 " << b + 1 << "//1 " << c + 1 << "//1\n";
  }
  return out.str();
}

inline std::string ply_text(const TriangleMesh& mesh) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\nelement vertex " << mesh.vertices.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
      << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Eigen::Vector3d& v : mesh.vertices)
    out << v.x() << " " << v.y() << " " << v.z() << "\n";
  for (const auto& [a, b, c] : mesh.triangles) out << "3 " << a << " " << b << " " << c << "\n";
  return out.str();
}

template <class T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline std::string stl_bytes(const TriangleMesh& mesh) {
  std::string bytes(80, ' ');
  put(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    bytes.append(12, '\0');  // its normal
    for (const int v : triangle) {
      for (const double x : mesh.vertices[static_cast<std::size_t>(v)]) {
        put(bytes, static_cast<float>(x));
      }
    }
    bytes.append(2, '\0');
  }
  return bytes;
}

inline std::string stl_text(const TriangleMesh& mesh) {
  std::ostringstream out;
  out << "solid thing\n";
  for (const auto& triangle : mesh.triangles) {
    out << "facet normal 0 0 0\n outer loop\n";
    for (const int v : triangle) {
      out << "  vertex " << mesh.vertices[static_cast<std::size_t>(v)].transpose() << "\n";
    }
    out << " endloop\nendfacet\n";
  }
  out << "endsolid thing\n";
  return out.str();
}

/// Its buffer lies in the file `buffer`, or in the chunk after the JSON where that is empty. The
/// node turns z to y and stretches by two.
inline std::string gltf_text(const TriangleMesh& mesh, const std::string& buffer) {
  const std::size_t vertices = 12 * mesh.vertices.size(), indices = 12 * mesh.triangles.size();
  std::ostringstream out;
  out << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,)"
      << R"("rotation":[-0.70710678,0,0,0.70710678],"scale":[2,2,2]}],"meshes":[{"primitives":[)"
      << R"({"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{"byteLength":)"
      << vertices + indices << (buffer.empty() ? "" : R"(,"uri":")" + buffer + "\"")
      << R"(}],"bufferViews":[{"buffer":0,"byteLength":)" << vertices
      << R"(},{"buffer":0,"byteOffset":)" << vertices << R"(,"byteLength":)" << indices
      << R"(}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":)"
      << mesh.vertices.size()
      << R"(},{"bufferView":1,"componentType":5125,"type":"SCALAR","count":)"
      << 3 * mesh.triangles.size() << "}]}";
  return out.str();
}

inline std::string gltf_buffer(const TriangleMesh& mesh) {
  std::string bytes;
  for (const Eigen::Vector3d& v : mesh.vertices) {
    for (const double x : v) put(bytes, static_cast<float>(x));
  }
  for (const auto& triangle : mesh.triangles) {
    for (const int v : triangle) put(bytes, static_cast<std::uint32_t>(v));
  }
  return bytes;
}

inline std::string glb_bytes(const TriangleMesh& mesh) {
  std::string json = gltf_text(mesh, "");
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string buffer = gltf_buffer(mesh);
  std::string bytes;
  put(bytes, std::uint32_t{0x46546C67});
  put(bytes, std::uint32_t{2});
  put(bytes, static_cast<std::uint32_t>(28 + json.size() + buffer.size()));
  put(bytes, static_cast<std::uint32_t>(json.size()));
  put(bytes, std::uint32_t{0x4E4F534A});
  bytes += json;
  put(bytes, static_cast<std::uint32_t>(buffer.size()));
  put(bytes, std::uint32_t{0x004E4942});
  return bytes + buffer;
}

/// Writes mesh files into the test's folder.
class MeshFile : public FolderTest {
 protected:
  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  std::string refusal(const std::string& name, const std::string& bytes) const {
    const fs::path file = write(name, bytes);
    const std::string sentence = sentence_of([&] { read_mesh(file); });
    EXPECT_THAT(sentence, testing::HasSubstr(name));
    return sentence;
  }
  /// One of each kind, by name and content.
  static std::vector<std::pair<std::string, std::string>> every_kind(const TriangleMesh& mesh) {
    return {{"a.obj", obj_text(mesh)},  {"a.ply", ply_text(mesh)},
            {"a.STL", stl_bytes(mesh)}, {"b.stl", stl_text(mesh)},
            {"a.glb", glb_bytes(mesh)}, {"a.gltf", gltf_text(mesh, "a.bin")}};
  }
};

}  // namespace kappamu::io
