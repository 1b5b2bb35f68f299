#include "io/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>

#include "core/mesh/mesh_check.h"
#include "core/mesh/shapes.h"
#include "core/process_memory.h"
#include "tests/io/mesh/mesh_texts.h"

namespace kappamu::io {
namespace {

using Eigen::Vector3d;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST_F(MeshFile, EveryFormatGivesTheSameBody) {
  const TriangleMesh mesh = torus_mesh(2.0, 0.5, 12);
  write("a.bin", gltf_buffer(mesh));
  for (const auto& [name, bytes] : every_kind(mesh)) {
    const CheckedMesh checked = read_body(write(name, bytes));
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
  const CheckedMesh checked = read_body(write("cube.obj", cube));
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
  write("a.bin", gltf_buffer(mesh));
  std::string gltf = gltf_text(mesh, "a.bin");
  gltf.replace(gltf.find("\"count\":36"), 10, "\"count\":360000000");
  EXPECT_THAT(refusal("a.gltf", gltf), HasSubstr("has 360000000 indices"));
  gltf.replace(gltf.find("\"count\":360000000"), 17, "\"count\":39");
  EXPECT_THAT(refusal("a.gltf", gltf), HasSubstr("beyond bufferView 1"));
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
              AllOf(HasSubstr("more than 2000000 triangles"), HasSubstr("decimate")));
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
  EXPECT_LT(spent.count(), 10.0);
}

TEST_F(MeshFile, PositionsThatAreNoNumbersAreRefused) {
  TriangleMesh mesh = box_mesh(Vector3d::Ones(), 2);
  mesh.vertices[3].z() = std::nan("");
  for (const auto& [name, bytes] : every_kind(mesh)) {
    if (name == "a.gltf") continue;
    const fs::path file = write(name, bytes);
    sentence_of([&] { read_body(file); });
  }
}

// No other file is read, whatever the names in this one.
TEST_F(MeshFile, BuffersOutsideTheFolderAreNotRead) {
  const TriangleMesh mesh = box_mesh(Vector3d::Ones(), 1);
  fs::create_directories(folder_ / "inner");
  write("a.bin", gltf_buffer(mesh));
  refusal("inner/a.gltf", gltf_text(mesh, "../a.bin"));
  refusal("inner/a.gltf", gltf_text(mesh, (folder_ / "a.bin").string()));
  refusal("inner/a.gltf", gltf_text(mesh, "%2E%2E/a.bin"));
  refusal("inner/a.gltf", gltf_text(mesh, "file:///a.bin"));
  EXPECT_THAT(refusal("a.gltf", gltf_text(mesh, "b.bin")), HasSubstr("'b.bin', which is missing"));
  write("inner/b.buffer", gltf_buffer(mesh));
  EXPECT_EQ(read_mesh(write("a.gltf", gltf_text(mesh, "inner/b.buffer"))).mesh.triangles.size(),
            12U);
  EXPECT_EQ(read_mesh(write("a.gltf", gltf_text(mesh, "a.bin"))).mesh.triangles.size(), 12U);
}

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
  EXPECT_THAT(refusal("late.ply", shifted), HasSubstr("holds more than its header"));
  std::string joined = ply;
  joined[joined.rfind('\n', joined.size() - 2)] = ' ';
  EXPECT_THAT(refusal("joined.ply", joined), HasSubstr("holds more than its header"));
  std::string commented = ply;
  commented.insert(commented.find('\n', commented.find("end_header")) + 1, " comment 0 0\n");
  EXPECT_THAT(refusal("comment.ply", commented),
              HasSubstr("vertex 0 has a coordinate that is not finite"));
  EXPECT_THAT(refusal("formats.ply",
                      "ply\nformat binary_little_endian 1.0\n" + ply.substr(ply.find("format"))),
              HasSubstr("names two formats"));
}

// Counts of the rest may disagree.
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
  EXPECT_EQ(read_mesh(skin).mesh.triangles.size(), 12U);
  EXPECT_THAT(refusal("fan.gltf", with("\"indices\":1}", "\"indices\":2,\"mode\":6}")),
              HasSubstr("number 2 of its accessors"));
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
      HasSubstr("extension ''"));
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
        read_body(file);
      } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      }
    }
  }
}

}  // namespace
}  // namespace kappamu::io
