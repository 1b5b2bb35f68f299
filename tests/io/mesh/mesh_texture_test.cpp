// Texture coordinates of meshes: read, kept while a mesh is mended and refined, left out with a
// note where they are not whole.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "core/mesh/mesh_refine.h"
#include "core/mesh/shapes.h"
#include "io/mesh_file.h"
#include "tests/own_folder.h"

namespace kappamu::io {
namespace {

using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// u = x, v = y + 10 z: a linear map of space, which is linear over every triangle.
Eigen::Vector2f mapped(const Vector3d& at) {
  return {static_cast<float>(at.x()), static_cast<float>(at.y() + 10.0 * at.z())};
}

void expect_mapped(const TriangleMesh& mesh) {
  ASSERT_EQ(mesh.texture.size(), mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d& at = mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][k])];
      EXPECT_LT((mesh.texture[t][k] - mapped(at)).norm(), 2e-4F) << t;
    }
  }
}

class MeshTexture : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  /// Each triangle with vertices and texture coordinates of its own, as exporters with seams write;
  /// every third is turned inside out, so that it has to be mended.
  std::string obj(const TriangleMesh& mesh, std::size_t without) {
    std::ostringstream text;
    text.precision(17);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (const int v : mesh.triangles[t]) {
        const Vector3d& at = mesh.vertices[static_cast<std::size_t>(v)];
        text << "v " << at.x() << " " << at.y() << " " << at.z() << "\n";
        text << "vt " << mapped(at).x() << " " << mapped(at).y() << "\n";
      }
      const bool bare = t < without;
      text << "f";
      for (const int k : t % 3 == 0 ? std::array{-3, -1, -2} : std::array{-3, -2, -1})
        text << " " << k << (bare ? "" : "/" + std::to_string(k));
      text << "\n";
    }
    return text.str();
  }
  OwnFolder folder_;
};

TEST_F(MeshTexture, ObjKeepsItThroughMendingAndRefinement) {
  const CheckedMesh body = read_body(write("a.obj", obj(torus_mesh(3.0, 1.0, 16), 0)));
  EXPECT_FALSE(body.mended.empty());
  expect_mapped(body.mesh);
  const TriangleMesh fine = refined(body.mesh, 0.3, 1'000'000);
  EXPECT_GT(fine.triangles.size(), 2 * body.mesh.triangles.size());
  expect_mapped(fine);
}

TEST_F(MeshTexture, PartOfItIsLeftOutWithANote) {
  const CheckedMesh body = read_body(write("a.obj", obj(sphere_mesh(3.0, 8), 5)));
  EXPECT_THAT(body.mesh.texture, IsEmpty());
  EXPECT_THAT(body.warnings, ElementsAre(HasSubstr("5 triangles have none")));
}

TEST_F(MeshTexture, PolygonsKeepTheirCorners) {
  std::ostringstream text;
  const TriangleMesh box = box_mesh({2.0, 3.0, 4.0}, 1);
  for (int k = 0; k < 8; ++k) {
    const Vector3d at(k & 1, k >> 1 & 1, k >> 2);
    text << "v " << at.x() << " " << at.y() << " " << at.z() << "\n"
         << "vt " << mapped(at).x() << " " << mapped(at).y() << "\n";
  }
  for (const char* quad : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"}) {
    std::istringstream corners(quad);
    text << "f";
    for (int corner = 0; corners >> corner;) text << " " << corner << "/" << corner;
    text << "\n";
  }
  expect_mapped(read_body(write("a.obj", text.str())).mesh);
}

TEST_F(MeshTexture, PlyVerticesHaveIt) {
  const TriangleMesh mesh = sphere_mesh(3.0, 8);
  std::ostringstream text;
  text.precision(17);
  text << "ply\nformat ascii 1.0\nelement vertex " << mesh.vertices.size()
       << "\nproperty double x\nproperty float s\nproperty double y\nproperty double z\n"
          "property float t\nelement face "
       << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vector3d& at : mesh.vertices) {
    text << at.x() << " " << mapped(at).x() << " " << at.y() << " " << at.z() << " "
         << mapped(at).y() << "\n";
  }
  for (const auto& t : mesh.triangles) text << "3 " << t[0] << " " << t[1] << " " << t[2] << "\n";
  expect_mapped(read_body(write("a.ply", text.str())).mesh);
}

TEST_F(MeshTexture, GltfHasIt) {
  const TriangleMesh mesh = sphere_mesh(3.0, 8);
  std::string buffer;
  const auto put = [&](float value) { buffer.append(reinterpret_cast<const char*>(&value), 4); };
  for (const auto& t : mesh.triangles) {
    for (const int v : t) {
      const Eigen::Vector3f at = mesh.vertices[static_cast<std::size_t>(v)].cast<float>();
      for (const float x : at) put(x);
    }
  }
  const std::size_t positions = buffer.size();
  for (const auto& t : mesh.triangles) {
    for (const int v : t) {
      for (const float x : mapped(mesh.vertices[static_cast<std::size_t>(v)])) put(x);
    }
  }
  write("a.bin", buffer);
  const std::string count = std::to_string(3 * mesh.triangles.size());
  const std::filesystem::path file = write(
      "a.gltf",
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
      "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1}}]}],
      "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":)" +
          count + R"(},{"bufferView":1,"componentType":5126,"type":"VEC2","count":)" + count +
          R"(}],"bufferViews":[{"buffer":0,"byteLength":)" + std::to_string(positions) +
          R"(},{"buffer":0,"byteOffset":)" + std::to_string(positions) + R"(,"byteLength":)" +
          std::to_string(buffer.size() - positions) +
          R"(}],"buffers":[{"uri":"a.bin","byteLength":)" + std::to_string(buffer.size()) + "}]}");
  expect_mapped(read_body(file).mesh);
}

TEST_F(MeshTexture, MeshesWithoutItHaveNone) {
  EXPECT_THAT(read_body(write("a.obj", obj(sphere_mesh(3.0, 8), 1'000'000))).mesh.texture,
              IsEmpty());
}

}  // namespace
}  // namespace kappamu::io
