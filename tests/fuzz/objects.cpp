// Scenes and triangle meshes.
#include <array>
#include <sstream>

#include "core/mesh/shapes.h"
#include "io/mesh_file.h"
#include "io/read_file.h"
#include "render/scene/scene.h"
#include "tests/fuzz/targets.h"

namespace kappamu::fuzz {

namespace fs = std::filesystem;

namespace {

constexpr std::array formats{"obj", "ply", "stl", "gltf", "glb"};

template <class T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

const TriangleMesh& small_mesh() {
  static const TriangleMesh mesh = cone_mesh(1.0, 2.0, 1);
  return mesh;
}

std::string obj() {
  std::ostringstream out;
  for (const Eigen::Vector3d& v : small_mesh().vertices) out << "v " << v.transpose() << "\n";
  for (const auto& [a, b, c] : small_mesh().triangles) {
    out << "f " << a + 1 << " " << b + 1 << " " << c + 1 << "\n";
  }
  return out.str();
}

std::string ply() {
  const TriangleMesh& mesh = small_mesh();
  std::ostringstream out;
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.vertices.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
      << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  std::string bytes = out.str();
  for (const Eigen::Vector3d& v : mesh.vertices) {
    for (const double x : v) put(bytes, static_cast<float>(x));
  }
  for (const auto& triangle : mesh.triangles) {
    put(bytes, std::uint8_t{3});
    for (const int v : triangle) put(bytes, v);
  }
  return bytes;
}

std::string stl() {
  std::string bytes(80, ' ');
  put(bytes, static_cast<std::uint32_t>(small_mesh().triangles.size()));
  for (const auto& triangle : small_mesh().triangles) {
    bytes.append(12, '\0');
    for (const int v : triangle) {
      for (const double x : small_mesh().vertices[static_cast<std::size_t>(v)]) {
        put(bytes, static_cast<float>(x));
      }
    }
    bytes.append(2, '\0');
  }
  return bytes;
}

/// Positions and indices of a tetrahedron.
std::string buffer() {
  std::string bytes;
  for (const float x : {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}) put(bytes, x);
  for (const int i : {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}) {
    put(bytes, static_cast<std::uint16_t>(i));
  }
  return bytes;
}

std::string gltf(const std::string& uri) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
         R"("accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",)"
         R"("min":[0,0,0],"max":[1,1,1]},)"
         R"({"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":48},)"
         R"({"buffer":0,"byteOffset":48,"byteLength":24}],)"
         R"("buffers":[{)" +
         uri + R"("byteLength":72}]})";
}

std::string glb() {
  std::string text = gltf("");
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::string data = buffer();
  std::string bytes = "glTF";
  for (const std::size_t n : {std::size_t{2}, 28 + text.size() + data.size(), text.size()}) {
    put(bytes, static_cast<std::uint32_t>(n));
  }
  bytes += "JSON" + text;
  put(bytes, static_cast<std::uint32_t>(data.size()));
  bytes.append("BIN\0", 4);
  return bytes + data;
}

}  // namespace

void read_scene(Bytes bytes) {
  const fs::path edits = folder() / "edits";  // recipes that scenes name
  if (!fs::exists(edits)) fs::copy(fs::path(KAPPAMU_SOURCE_DIR) / "scenes/edits", edits);
  write(folder() / "scene.json", bytes);
  render::read_scene(folder() / "scene.json");
}

void seed_scene(const fs::path& seeds) {
  for (const auto& entry : fs::directory_iterator(fs::path(KAPPAMU_SOURCE_DIR) / "scenes")) {
    if (entry.path().extension() != ".json") continue;
    write(seeds / entry.path().filename(), bytes_of(io::read_text(entry.path())));
  }
}

void read_mesh(Bytes bytes) {
  if (bytes.empty()) return;
  const std::string name = std::string("mesh.") + formats[bytes.front() % formats.size()];
  write(folder() / name, bytes.subspan(1));
  io::read_body(folder() / name);
}

void seed_mesh(const fs::path& seeds) {
  write(folder() / "buffer.bin", bytes_of(buffer()));
  const std::string contents[] = {obj(), ply(), stl(), gltf(R"("uri":"buffer.bin",)"), glb()};
  for (std::size_t i = 0; i < formats.size(); ++i) {
    write(seeds / formats[i], bytes_of(static_cast<char>(i) + contents[i]));
  }
}

}  // namespace kappamu::fuzz
