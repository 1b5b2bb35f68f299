// What each kind of mesh file may hold, as programs write it: read, or refused by the true reason.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>

#include "core/mesh/shapes.h"
#include "tests/io/mesh/mesh_texts.h"

namespace kappamu::io {
namespace {

using Eigen::Vector3d;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string bom = "\xEF\xBB\xBF";
const std::string block =
    "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nv 0 0 4\nv 2 0 4\nv 2 3 4\nv 0 3 4\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

TriangleMesh block_mesh() {
  return moved(box_mesh({2.0, 3.0, 4.0}, 1), {1.0, 1.5, 2.0});
}

std::string with(std::string text, const std::string& old, const std::string& by) {
  for (std::size_t at = text.find(old); at != text.npos; at = text.find(old, at + by.size())) {
    text.replace(at, old.size(), by);
  }
  return text;
}

std::string reversed(std::string bytes) {
  std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

class MeshFormats : public MeshFile {
 protected:
  /// Read without a word as the block of 2 x 3 x 4.
  void expect_block(const std::string& name, const std::string& bytes) const {
    const CheckedMesh body = read_body(write(name, bytes));
    EXPECT_NEAR(enclosed_volume(body.mesh), 24.0, 1e-5) << name;
    EXPECT_EQ(body.mesh.vertices.size(), 8U) << name;
    EXPECT_THAT(body.mended, IsEmpty()) << name;
    EXPECT_THAT(body.warnings, IsEmpty()) << name;
  }
};

TEST_F(MeshFormats, ObjAsProgramsWriteIt) {
  expect_block("bom.obj", bom + block);
  expect_block("crlf.obj", with(block, "\n", "\r\n"));
  expect_block("cr.obj", with(block, "\n", "\r"));
  expect_block("no_vt.obj", with(with(block, "f 1 4 3 2", "f 1/1/1 4/4/1 3/3/1 2/2/1"), "f 5 6 7 8",
                                 "f 5//2 6//2 7//2 8//2"));
  expect_block("negative.obj", with(block, "f 5 6 7 8", "f -4 -3 -2 -1"));
  expect_block("continued.obj",
               with(with(block, "f 5 6 7 8", "f 5 6 \\\n 7\\\r\n 8"), "v 2 3 4", "v 2 \\\n3 4"));
  expect_block("comment.obj",
               "# from C:\\models\\\n" + with(block, "f 5 6 7 8", "f 5 6 7 8 # top"));
  expect_block("plus.obj", with(block, "v 2 3 4", "v +2.0e0 3.00 +4 1.0"));
  expect_block("colours.obj", with(block, "v 2 3 4", "v 2 3 4 0.5 0.25 1"));
  const std::size_t faces = block.find("f ");
  expect_block("faces_first.obj", block.substr(faces) + block.substr(0, faces));
  expect_block("tabs.OBJ", with(block, " ", "\t"));
}

// 24 vertices for the normals of a block are what every exporter of game engines writes.
TEST_F(MeshFormats, VerticesRepeatedForNormalsAreNoMatter) {
  std::string text;
  const TriangleMesh mesh = block_mesh();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const int v : mesh.triangles[t]) {
      const Vector3d& p = mesh.vertices[static_cast<std::size_t>(v)];
      text += "v " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " +
              std::to_string(p.z()) + "\n";
    }
    const auto corner = [&](std::size_t k) {
      const std::string n = std::to_string(3 * t + k + 1);
      return " " + n + "/" + n + "/" + n;
    };
    text += "f" + corner(0) + corner(1) + corner(2) + "\n";
  }
  expect_block("cube.obj", text);
}

TEST_F(MeshFormats, ObjSentencesNameItsLines) {
  EXPECT_THAT(refusal("far.obj", with(block, "f 1 2 6 5", "f 1 2 6 9")),
              HasSubstr("line 11 names vertex 9, and the file has vertices 1 to 8"));
  EXPECT_THAT(refusal("zero.obj", with(block, "f 1 2 6 5", "f 0 2 6 5")),
              HasSubstr("line 11 names vertex 0"));
  EXPECT_THAT(refusal("comma.obj", with(block, "v 2 3 4", "v 2,0 3 4")),
              HasSubstr("line 7 gives a vertex the coordinate '2,0'"));
  EXPECT_THAT(refusal("nan.obj", with(block, "v 2 3 4", "v nan 3 4")), HasSubstr("line 7"));
  EXPECT_THAT(refusal("short.obj", with(block, "v 2 3 4", "v 2 3")), HasSubstr("line 7"));
  EXPECT_THAT(refusal("weight.obj", with(block, "v 2 3 4", "v 2 3 4 2")),
              HasSubstr("line 7 gives a vertex the weight '2', not 1"));
  const auto body = [&](const std::string& name, const std::string& text) {
    const fs::path file = write(name, text);
    return sentence_of([&] { read_body(file); });
  };
  EXPECT_THAT(body("hole.obj", with(block, "f 5 6 7 8\n", "\n")), HasSubstr("(line 11)"));
  EXPECT_THAT(refusal("wires.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nl 2 3\np 1\nf 1 2\n"),
              AllOf(HasSubstr("has no triangles but lines (2), points (1)"),
                    HasSubstr("faces of fewer than three corners (1), which bound nothing")));
  EXPECT_THAT(body("flat.obj", "v 0 0 0\nv 1 2 3\nv 1 1 1\nf 1 1 2\nf 2 3 2\n"),
              HasSubstr("of 2, 2 have two corners at one place"));
}

TEST_F(MeshFormats, BodiesOfAFileAreNamed) {
  const std::string lid = with(with(block, "v 0", "v 9"), "v 2", "v 11");
  std::string second = "o lid\n" + lid.substr(0, lid.find("f "));
  // Inside out, its vertices after those of the first.
  for (const char* face : {"2 3 4 1", "8 7 6 5", "5 6 2 1", "6 7 3 2", "7 8 4 3", "8 5 1 4"}) {
    second += "f";
    for (const char digit : std::string(face)) {
      if (digit != ' ') second += " " + std::to_string(digit - '0' + 8);
    }
    second += "\n";
  }
  const CheckedMesh two = read_body(write("two.obj", "o box\n" + block + second));
  EXPECT_NEAR(enclosed_volume(two.mesh), 48.0, 1e-9);
  EXPECT_THAT(two.mended, Contains(AllOf(HasSubstr("two.obj: 1 body that faced inwards"),
                                         HasSubstr("that of line 25, object 'lid'"))));
  // A corner of a cube, whose faces lie upon the cube's own.
  const std::string cube =
      "v 0 0 0\nv 0 0 1\nv 0 1 0\nv 0 1 1\nv 1 0 0\nv 1 0 1\nv 1 1 0\nv 1 1 1\n"
      "f 1 7 5\nf 1 3 7\nf 1 4 3\nf 1 2 4\nf 3 8 7\nf 3 4 8\n"
      "f 5 7 8\nf 5 8 6\nf 1 5 6\nf 1 6 2\nf 2 6 8\nf 2 8 4\n";
  const std::string corner =
      "o corner\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
      "f 9 11 10\nf 9 12 11\nf 10 12 9\nf 10 11 12\n";
  const fs::path file = write("upon.obj", "o box\n" + cube + corner);
  EXPECT_THAT(sentence_of([&] { read_body(file); }),
              AllOf(HasSubstr("upon.obj: two of its bodies intersect or lie upon"),
                    HasSubstr("object 'box'"), HasSubstr("object 'corner'"), HasSubstr("unite")));
}

// Survey coordinates: 32-bit numbers are half a metre apart there.
TEST_F(MeshFormats, FarFromTheOriginTheBodyIsTheSame) {
  const Vector3d place(412'343.0493, 5'654'321.123, 123.4);
  const TriangleMesh ball = sphere_mesh(5.0, 12), there = moved(ball, place);
  std::ostringstream obj;
  obj.precision(14);
  for (const Vector3d& v : there.vertices) obj << "v " << v.transpose() << "\n";
  for (const auto& [a, b, c] : ball.triangles) {
    obj << "f " << a + 1 << " " << b + 1 << " " << c + 1 << "\n";
  }
  std::string stored = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                       std::to_string(ball.vertices.size()) +
                       "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                       std::to_string(ball.triangles.size()) +
                       "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vector3d& v : there.vertices) {
    for (const double x : v) put(stored, x);
  }
  for (const auto& triangle : ball.triangles) {
    put(stored, std::uint8_t{3});
    for (const int v : triangle) put(stored, v);
  }
  const auto area = [](const TriangleMesh& mesh) {
    double sum = 0.0;
    for (const double a : surface_of(mesh).area) sum += a;
    return sum;
  };
  for (const auto& [name, bytes] :
       {std::pair("far.obj", obj.str()), std::pair("far.ply", stored)}) {
    const CheckedMesh body = read_body(write(name, bytes));
    EXPECT_THAT(body.mended, IsEmpty()) << name;
    EXPECT_NEAR(area(fitted(body.mesh, 10.0)) / area(fitted(ball, 10.0)), 1.0, 1e-8) << name;
  }
  EXPECT_THAT(
      refusal("far.stl", stl_bytes(there)),
      AllOf(HasSubstr("32-bit numbers are 0.67 apart"), HasSubstr("move it to the origin")));
  TriangleMesh open = there;  // a hole's place is told as the file has it
  open.triangles.pop_back();
  std::ostringstream holed;
  holed.precision(14);
  for (const Vector3d& v : open.vertices) holed << "v " << v.transpose() << "\n";
  for (const auto& [a, b, c] : open.triangles) {
    holed << "f " << a + 1 << " " << b + 1 << " " << c + 1 << "\n";
  }
  const fs::path file = write("holed.obj", holed.str());
  EXPECT_THAT(sentence_of([&] { read_body(file); }), HasSubstr("(4123"));
}

/// The block as a binary PLY of these types; `before` is put between its parts.
std::string ply_block(const std::string& end, bool big, double first_x = 0.0) {
  std::string bytes = with("ply\nformat binary_" + std::string(big ? "big" : "little") +
                               "_endian 1.0\ncomment by a test\nelement camera 1\n"
                               "property double fx\nproperty list uchar double k\n"
                               "element vertex 8\nproperty uchar quality\nproperty double x\n"
                               "property double y\nproperty float z\nelement face 12\n"
                               "property list uint ushort vertex_index\nproperty list uchar float "
                               "texcoord\nend_header\n",
                           "\n", end);
  const auto add = [&](const auto& value) {
    std::string one;
    put(one, value);
    bytes += big ? reversed(one) : one;
  };
  add(1500.0);
  add(std::uint8_t{2});
  add(0.5);
  add(0.25);
  const double x[2] = {first_x, first_x + 2.0}, y[2] = {0.0, 3.0};
  const float z[2] = {0.0F, 4.0F};
  for (std::size_t v = 0; v < 8; ++v) {
    add(std::uint8_t{10});
    add(x[v & 1]);
    add(y[v >> 1 & 1]);
    add(z[v >> 2]);
  }
  for (const char* face :
       {"021", "123", "456", "657", "014", "154", "267", "273", "042", "246", "135", "375"}) {
    add(std::uint32_t{3});
    for (int k = 0; k < 3; ++k) add(static_cast<std::uint16_t>(face[k] - '0'));
    add(std::uint8_t{1});
    add(0.5F);
  }
  return bytes;
}

TEST_F(MeshFormats, PlyAsProgramsWriteIt) {
  for (const char* end : {"\n", "\r\n", "\r"}) {
    for (const bool big : {false, true}) expect_block("a.ply", ply_block(end, big));
  }
  // Vertices first, so that the byte after the header is theirs: 0x0A, a line feed.
  for (const char* end : {"\n", "\r\n", "\r"}) {
    std::string ply = ply_block(end, false);
    const std::string camera = with(
        "element camera 1\nproperty double fx\nproperty list uchar "
        "double k\n",
        "\n", end);
    ply.erase(ply.find(camera), camera.size());
    ply.erase(ply.find("end_header") + 10 + std::strlen(end), 25);
    ASSERT_EQ(ply[ply.find("end_header") + 10 + std::strlen(end)], '\n');
    expect_block("first.PLY", ply);
    const CheckedMesh body = read_body(write("longer.ply", ply + "   "));
    EXPECT_THAT(body.warnings, Contains(HasSubstr("3 bytes after its last element left unread")));
  }
  const std::string text = ply_text(block_mesh());
  expect_block("bom.ply", bom + text);
  expect_block("crlf.ply", with(text, "\n", "\r\n"));
  expect_block("spaced.ply", with(text, "end_header\n", "end_header\n\n") + "\n\n");
}

TEST_F(MeshFormats, PlySentencesNameWhatIsWrong) {
  const std::string ply = ply_block("\n", false), text = ply_text(block_mesh());
  EXPECT_THAT(refusal("cut.ply", ply.substr(0, ply.size() - 3)), HasSubstr("in face 11"));
  EXPECT_THAT(refusal("type.ply", with(ply, "property float z", "property real z")),
              HasSubstr("names type 'real'"));
  EXPECT_THAT(refusal("flat.ply", with(text, "property float z", "property float depth")),
              HasSubstr("lack x, y or z"));
  EXPECT_THAT(refusal("far.ply", with(text, "\n3 0 ", "\n3 99 ")),
              HasSubstr("names vertex 99, and there are 8, from 0"));
  EXPECT_THAT(refusal("minus.ply", with(text, "\n3 0 ", "\n3 -1 ")), HasSubstr("names vertex -1"));
  EXPECT_THAT(refusal("points.ply",
                      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                      "property float y\nproperty float z\nend_header\n1 2 3\n"),
              HasSubstr("has no triangles"));
}

TEST_F(MeshFormats, StlAsProgramsWriteIt) {
  const std::string text = stl_text(block_mesh()), bytes = stl_bytes(block_mesh());
  expect_block("a.stl", text);
  expect_block("capitals.stl",
               with(with(with(text, "solid", "SOLID"), "facet", "FACET"), "vertex", "VERTEX"));
  expect_block("blank.stl", "\n  \n" + text);
  expect_block("bom.stl", bom + text);
  expect_block("crlf.stl", with(text, "\n", "\r\n"));
  expect_block("coloured.stl", with(text, " outer loop", " color 1 0 0\n outer loop"));
  expect_block("one_line.stl", "solid thing\n" + with(text.substr(12), "\n", " "));
  std::string solid = bytes;
  solid.replace(0, 11, "solid facet");
  expect_block("solid.stl", solid);
  const CheckedMesh body = read_body(write("longer.stl", solid + "\n\n"));
  EXPECT_NEAR(enclosed_volume(body.mesh), 24.0, 1e-5);
  EXPECT_THAT(body.warnings, Contains(HasSubstr("2 bytes after its last triangle left unread")));
  EXPECT_THAT(refusal("cut.stl", solid.substr(0, 400)),
              AllOf(HasSubstr("is cut short"), HasSubstr("declares 12 triangles")));
  std::string more = bytes + std::string(50, '\0');
  EXPECT_THAT(refusal("count.stl", more), HasSubstr("declares 12 triangles, and the file has bytes "
                                                    "for 13"));
  EXPECT_THAT(refusal("cut_text.stl", text.substr(0, text.rfind("endfacet"))),
              HasSubstr("is cut short"));
  EXPECT_THAT(refusal("empty.stl", "solid nothing\nendsolid nothing\n"),
              HasSubstr("has no triangles"));
  EXPECT_THAT(refusal("comma.stl", with(text, "vertex 2", "vertex 2,")), HasSubstr("line "));
}

TEST_F(MeshFormats, GltfAsProgramsWriteIt) {
  const TriangleMesh mesh = block_mesh();
  const std::string buffer = gltf_buffer(mesh);
  const std::string plain = with(with(gltf_text(mesh, "my%20buffer.bin"), "[2,2,2]", "[1,1,1]"),
                                 "-0.70710678,0,0,0.70710678", "0,0,0,1");
  write("my buffer.bin", buffer);
  expect_block("escaped.GLTF", plain);
  expect_block("bom.gltf", bom + plain);
  const auto also = [&](const std::string& accessor) {
    return plain.substr(0, plain.size() - 2) + "," + accessor + "]}";
  };
  // The third index names the vertex that takes the position of vertex 1.
  const std::string sparse =
      R"({"componentType":5126,"type":"VEC3","count":8,"bufferView":0,"sparse":{"count":1,)"
      R"("indices":{"bufferView":1,"byteOffset":8,"componentType":5125},)"
      R"("values":{"bufferView":0,"byteOffset":12}}})";
  expect_block("morph.gltf",
               with(also(sparse), R"("indices":1})", R"("indices":1,"targets":[{"POSITION":2}]})"));
  // The target has the positions themselves: a weight of 1 doubles the block.
  const std::string morphed =
      with(plain, R"("indices":1})", R"("indices":1,"targets":[{"POSITION":0}]})");
  const fs::path morph = write("weighed.gltf", morphed);
  const std::vector<double> one{1.0}, two{1.0, 0.5};
  EXPECT_NEAR(enclosed_volume(read_body(morph, one).mesh), 8.0 * 24.0, 1e-4);
  EXPECT_THAT(sentence_of([&] { read_body(morph, two); }),
              HasSubstr("has 1 morph targets and 2 weights"));
  EXPECT_THAT(sentence_of([&] { read_body(write("a.obj", block), one); }),
              HasSubstr("has no morph targets"));
  std::uint32_t replaced = 0;
  std::memcpy(&replaced, buffer.data() + 12 * mesh.vertices.size() + 8, 4);
  const FileMesh read =
      read_mesh(write("sparse.gltf", with(also(sparse), R"("POSITION":0)", R"("POSITION":2)")));
  EXPECT_LT((read.mesh.vertices[replaced] - mesh.vertices[1]).norm(), 1e-6);
  EXPECT_LT((read.mesh.vertices[replaced ^ 1] - mesh.vertices[replaced ^ 1]).norm(), 1e-6);
  // In the file itself.
  std::string data = "data:application/octet-stream;base64,";
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < buffer.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8 | static_cast<unsigned char>(buffer[i + k]);
    }
    for (int k = 3; k >= 0; --k) data += digits[bits >> (6 * k) & 63];
  }
  ASSERT_EQ(buffer.size() % 3, 0U);
  expect_block("data.gltf", with(plain, "my%20buffer.bin", data));
  EXPECT_THAT(refusal("cut.gltf", with(plain, "my%20buffer.bin", data.substr(0, data.size() - 4))),
              HasSubstr("is cut short: it has 237 of 240 bytes"));
  // Of whatever ending; nodes turn and stretch it, and mirror it.
  write("a.GLB", glb_bytes(mesh));
  EXPECT_NEAR(enclosed_volume(read_body(folder_ / "a.GLB").mesh), 8.0 * 24.0, 1e-3);
  write("b.gltf", glb_bytes(mesh) + "    ");
  EXPECT_NEAR(enclosed_volume(read_body(folder_ / "b.gltf").mesh), 8.0 * 24.0, 1e-3);
  const CheckedMesh mirrored = read_body(write("mirror.gltf", with(plain, "[1,1,1]", "[-1,1,1]")));
  EXPECT_THAT(mirrored.mended, IsEmpty());
  EXPECT_NEAR(bounding_box(mirrored.mesh).min().x(), -2.0, 1e-6);
  const std::string matrix = with(plain, R"("rotation":[0,0,0,1],"scale":[1,1,1])",
                                  R"("matrix":[0,1,0,0,-1,0,0,0,0,0,1,0,7,8,9,1])");
  const Eigen::AlignedBox3d box = bounding_box(read_body(write("matrix.gltf", matrix)).mesh);
  EXPECT_LT((box.min() - Vector3d(4.0, 8.0, 9.0)).norm(), 1e-6);
  EXPECT_LT((box.max() - Vector3d(7.0, 10.0, 13.0)).norm(), 1e-6);
  EXPECT_THAT(refusal("loop.gltf", with(plain, R"({"mesh":0,)", R"({"mesh":0,"children":[0],)")),
              HasSubstr("children of themselves"));
  EXPECT_THAT(refusal("old.gltf", with(plain, "2.0", "1.0")), HasSubstr("version 2"));
}

// An L of which no corner sees all others, and corners on a straight edge: any fan leaves it.
TEST_F(MeshFormats, PolygonsNeedNotBeConvex) {
  const std::string prism =
      "v 0 0 0\nv 1 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\n"
      "v 0 0 1\nv 1 0 1\nv 3 0 1\nv 3 1 1\nv 1 1 1\nv 1 3 1\nv 0 3 1\n"
      "f 7 6 5 4 3 2 1\nf 8 9 10 11 12 13 14\nf 1 2 9 8\nf 2 3 10 9\nf 3 4 11 10\n"
      "f 4 5 12 11\nf 5 6 13 12\nf 6 7 14 13\nf 7 1 8 14\n";
  const CheckedMesh body = read_body(write("l.obj", prism));
  EXPECT_NEAR(enclosed_volume(body.mesh), 5.0, 1e-9);
  double area = 0.0;
  for (const double a : surface_of(body.mesh).area) area += a;
  EXPECT_NEAR(area, 22.0, 1e-9);
  EXPECT_THAT(body.mended, IsEmpty());
  EXPECT_THAT(body.warnings, IsEmpty());
}

}  // namespace
}  // namespace kappamu::io
