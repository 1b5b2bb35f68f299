#include "io/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <random>
#include <sstream>
#include <string>

#include "core/mesh/mesh_check.h"
#include "core/mesh/shapes.h"
#include "core/process_memory.h"
#include "tests/io/support.h"

namespace kappamu::io {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string obj_text(const TriangleMesh& mesh) {
  std::ostringstream out;
  out << "# a comment\nmtllib other.mtl\no thing\n";
  for (const Vector3d& v : mesh.vertices)
    out << "v " << v.x() << " " << v.y() << " " << v.z() << "\n";
  out << "vn 0 0 1\nusemtl red\n";
  for (const auto& [a, b, c] : mesh.triangles) {
    out << "f " << a + 1 << "//1 " << b + 1 << "//1 " << c + 1 << "//1\n";
  }
  return out.str();
}

std::string ply_text(const TriangleMesh& mesh) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\nelement vertex " << mesh.vertices.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
      << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vector3d& v : mesh.vertices) out << v.x() << " " << v.y() << " " << v.z() << "\n";
  for (const auto& [a, b, c] : mesh.triangles) out << "3 " << a << " " << b << " " << c << "\n";
  return out.str();
}

template <class T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string stl_bytes(const TriangleMesh& mesh) {
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

std::string stl_text(const TriangleMesh& mesh) {
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
std::string gltf_text(const TriangleMesh& mesh, const std::string& buffer) {
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

std::string gltf_buffer(const TriangleMesh& mesh) {
  std::string bytes;
  for (const Vector3d& v : mesh.vertices) {
    for (const double x : v) put(bytes, static_cast<float>(x));
  }
  for (const auto& triangle : mesh.triangles) {
    for (const int v : triangle) put(bytes, static_cast<std::uint32_t>(v));
  }
  return bytes;
}

std::string glb_bytes(const TriangleMesh& mesh) {
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

class MeshFile : public FolderTest {
 protected:
  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  std::string refusal(const std::string& name, const std::string& bytes) const {
    const fs::path file = write(name, bytes);
    const std::string sentence = sentence_of([&] { read_mesh(file); });
    EXPECT_THAT(sentence, HasSubstr(name));
    return sentence;
  }
  /// One of each kind, by name and content.
  static std::vector<std::pair<std::string, std::string>> every_kind(const TriangleMesh& mesh) {
    return {{"a.obj", obj_text(mesh)},  {"a.ply", ply_text(mesh)},
            {"a.STL", stl_bytes(mesh)}, {"b.stl", stl_text(mesh)},
            {"a.glb", glb_bytes(mesh)}, {"a.gltf", gltf_text(mesh, "a.bin")}};
  }
};

TEST_F(MeshFile, EveryFormatGivesTheSameBody) {
  const TriangleMesh mesh = torus_mesh(2.0, 0.5, 12);
  write("a.bin", gltf_buffer(mesh));
  for (const auto& [name, bytes] : every_kind(mesh)) {
    const CheckedMesh checked = check_mesh(read_mesh(write(name, bytes)), name);
    EXPECT_EQ(checked.mesh.vertices.size(), mesh.vertices.size()) << name;
    EXPECT_EQ(checked.mesh.triangles.size(), mesh.triangles.size()) << name;
    const bool stretched = name.find(".gl") != std::string::npos;
    EXPECT_NEAR(enclosed_volume(checked.mesh), enclosed_volume(mesh) * (stretched ? 8.0 : 1.0),
                1e-3)
        << name;
    const Vector3d size = bounding_box(checked.mesh).sizes();
    EXPECT_NEAR(stretched ? size.y() / 2.0 : size.z(), bounding_box(mesh).sizes().z(), 1e-4);
  }
}

TEST_F(MeshFile, PolygonsBecomeTriangles) {
  const std::string cube =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
      "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  const CheckedMesh checked = check_mesh(read_mesh(write("cube.obj", cube)), "cube.obj");
  EXPECT_EQ(checked.mesh.triangles.size(), 12U);
  EXPECT_NEAR(enclosed_volume(checked.mesh), 1.0, 1e-6);
}

TEST_F(MeshFile, WhatIsNoMeshIsRefused) {
  EXPECT_THAT(refusal("a.blend", "x"), HasSubstr("give .obj"));
  EXPECT_THAT(sentence_of([&] { read_mesh(folder_ / "none.obj"); }), HasSubstr("no such file"));
  for (const char* name : {"a.obj", "a.ply", "a.stl", "a.gltf", "a.glb"}) {
    refusal(name, "");
    refusal(name, "nothing of the kind\n");
    refusal(name, std::string(1000, '\0'));
  }
  EXPECT_THAT(refusal("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n"),
              HasSubstr("no triangles"));
}

// What a header declares is refused before anything is allocated for it.
TEST_F(MeshFile, DeclaredSizesAreCheckedFirst) {
  const double before = peak_memory();
  std::string stl(84, ' ');
  const std::uint32_t many = 80'000'000;
  std::memcpy(stl.data() + 80, &many, sizeof many);
  EXPECT_THAT(refusal("a.stl", stl), HasSubstr("declares 80000000 triangles"));
  EXPECT_THAT(refusal("a.ply",
                      "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\n"
                      "element face 1\nend_header\n1\n"),
              HasSubstr("declares '4000000000'"));
  const TriangleMesh mesh = box_mesh(Vector3d::Ones(), 1);
  std::string gltf = gltf_text(mesh, "a.bin");
  gltf.replace(gltf.find("\"count\":36"), 10, "\"count\":360000000");
  EXPECT_THAT(refusal("a.gltf", gltf), HasSubstr("bufferView 1"));
  std::string polygon = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
  for (int i = 0; i < 100'000; ++i) polygon += " 1 2 3";
  EXPECT_THAT(refusal("a.obj", polygon + "\n"), AllOf(HasSubstr("line 4"), HasSubstr("300000")));
  EXPECT_LT(peak_memory() - before, 1e8);
}

TEST_F(MeshFile, TenMillionTrianglesAreRefusedAtOnce) {
  std::string faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 10'000'000; ++i) faces += "f 1 2 3\n";
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THAT(refusal("a.obj", faces),
              AllOf(HasSubstr("10000000 triangles"), HasSubstr("decimate")));
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
  EXPECT_LT(spent.count(), 10.0);
}

TEST_F(MeshFile, PositionsThatAreNoNumbersAreRefused) {
  TriangleMesh mesh = box_mesh(Vector3d::Ones(), 2);
  mesh.vertices[3].z() = std::nan("");
  for (const auto& [name, bytes] : every_kind(mesh)) {
    if (name == "a.gltf") continue;
    const fs::path file = write(name, bytes);
    sentence_of([&, n = name] { check_mesh(read_mesh(file), n); });
  }
}

// No other file is read, whatever the names in this one.
TEST_F(MeshFile, BuffersOutsideTheFolderAreNotRead) {
  const TriangleMesh mesh = box_mesh(Vector3d::Ones(), 1);
  fs::create_directories(folder_ / "inner");
  write("a.bin", gltf_buffer(mesh));
  write("a.txt", gltf_buffer(mesh));
  refusal("inner/a.gltf", gltf_text(mesh, "../a.bin"));
  refusal("inner/a.gltf", gltf_text(mesh, (folder_ / "a.bin").string()));
  refusal("a.gltf", gltf_text(mesh, "a.txt"));
  EXPECT_EQ(read_mesh(write("a.gltf", gltf_text(mesh, "a.bin"))).triangles.size(), 12U);
}

// Assimp 5.2 makes room for the first element of a kind and writes the second one's past its end.
TEST_F(MeshFile, PlyElementsOfAKindComeOnce) {
  std::string ply = ply_text(box_mesh(Vector3d::Ones(), 1));
  const std::size_t face = ply.find("element face");
  EXPECT_THAT(
      refusal("faces.ply", ply.substr(0, face) + "element face 1\nproperty list uchar int i\n" +
                               ply.substr(face)),
      HasSubstr("'face' twice"));
  const std::size_t vertex = ply.find("element vertex");
  EXPECT_THAT(
      refusal("vertices.ply",
              ply.substr(0, vertex) + "element vertex 1\nproperty float x\n" + ply.substr(vertex)),
      HasSubstr("'vertex' twice"));
  ply.replace(face, 12, "element tristrips");
  EXPECT_THAT(refusal("strips.ply", ply), HasSubstr("export it again with faces"));
}

TEST_F(MeshFile, PlyBodiesHoldWhatTheHeaderDeclares) {
  const std::string ply = ply_text(box_mesh(Vector3d::Ones(), 1));
  std::string long_list = ply;
  long_list.replace(long_list.rfind("\n3 ") + 1, 1, "3000000000");
  EXPECT_THAT(refusal("list.ply", long_list), HasSubstr("has 3000000000 values"));
  EXPECT_THAT(refusal("cut.ply", ply.substr(0, ply.size() - 8)),
              HasSubstr("before what its header declares"));
  std::string shifted = ply;
  shifted.insert(shifted.find('\n', shifted.find("end_header") + 12), " 1");
  EXPECT_THAT(refusal("late.ply", shifted), HasSubstr("a line holds more"));
  std::string joined = ply;
  joined[joined.rfind('\n', joined.size() - 2)] = ' ';
  EXPECT_THAT(refusal("joined.ply", joined), HasSubstr("a line holds more"));
  std::string commented = ply;
  commented.insert(commented.find('\n', commented.find("end_header")) + 1, " comment 0 0\n");
  EXPECT_THAT(refusal("comment.ply", commented), HasSubstr("a comment stands among"));
  std::string old = ply;
  old[old.rfind('\n', old.size() - 2)] = '\r';
  EXPECT_THAT(refusal("return.ply", old), HasSubstr("control character"));
  EXPECT_THAT(refusal("formats.ply",
                      "ply\nformat binary_little_endian 1.0\n" + ply.substr(ply.find("format"))),
              HasSubstr("names two formats"));
}

// Nothing but triangles reaches assimp, which writes out of bounds where the counts of the rest
// disagree.
TEST_F(MeshFile, GltfIsReadForItsTrianglesAlone) {
  const TriangleMesh mesh = box_mesh(Vector3d::Ones(), 1);
  write("a.bin", gltf_buffer(mesh));
  const std::string whole = gltf_text(mesh, "a.bin");
  const auto with = [&](const std::string& old, const std::string& by) {
    std::string text = whole;
    text.replace(text.find(old), old.size(), by);
    return text;
  };
  const fs::path skin =
      write("skin.gltf",
            with("\"attributes\":{", R"("attributes":{"JOINTS_0":1,"WEIGHTS_0":0,"NORMAL":1,)"));
  EXPECT_EQ(read_mesh(skin).triangles.size(), 12U);
  EXPECT_THAT(refusal("fan.gltf", with("\"indices\":1}", "\"indices\":2,\"mode\":6}")),
              HasSubstr("accessor 2"));
  EXPECT_THAT(refusal("few.gltf", with("\"indices\":1}", "\"indices\":1,\"mode\":7}")),
              HasSubstr("no known mode"));
  EXPECT_THAT(refusal("kind.gltf", with("\"POSITION\":0", "\"POSITION\":1")),
              HasSubstr("POSITION"));
  EXPECT_THAT(refusal("deep.gltf",
                      with("\"mesh\":0,", "\"mesh\":0,\"children\":" + std::string(100'000, '[') +
                                              std::string(100'000, ']') + ",")),
              HasSubstr("children"));
  const auto requiring = [&](const std::string& extension) {
    return with("{", R"({"extensionsRequired":[)" + extension + "],");
  };
  EXPECT_THAT(refusal("needs.gltf", requiring("\"KHR_mesh\"")),
              HasSubstr("needs the glTF extension 'KHR_mesh'; export it without extensions"));
  EXPECT_THAT(
      refusal("deep_need.gltf", requiring(std::string(100'000, '[') + std::string(100'000, ']'))),
      HasSubstr("of no name"));
}

// Bytes changed, cut and repeated at random: read, or refused with a sentence.
TEST_F(MeshFile, DamagedFilesAreReadOrRefused) {
  const TriangleMesh mesh = box_mesh(Vector3d::Ones(), 2);
  write("a.bin", gltf_buffer(mesh));
  std::mt19937 random(1);
  for (const auto& [name, whole] : every_kind(mesh)) {
    for (int trial = 0; trial < 100; ++trial) {
      std::string bytes = whole;
      for (int change = 0; change < 1 + trial % 4; ++change) {
        bytes[random() % bytes.size()] = static_cast<char>(random());
      }
      if (trial % 5 == 0) bytes.resize(random() % bytes.size());
      if (trial % 7 == 0)
        bytes.insert(random() % (bytes.size() + 1), bytes.substr(bytes.size() / 2));
      const fs::path file = write(name, bytes);
      try {
        check_mesh(read_mesh(file), name);
      } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      }
    }
  }
}

}  // namespace
}  // namespace kappamu::io
