// Scenes and meshes that cannot be rendered: `kappamu render` refuses each in one sentence, within
// bounded memory, and what its folder held stays as it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "core/mesh/shapes.h"
#include "io/atomic_file.h"
#include "io/read_file.h"
#include "io/volume/volume_file.h"
#include "process.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Address space in kB that a refused scene must do with; libraries alone take half of it.
constexpr const char* memory_limit = "ulimit -v 3000000;";

class HostileScenes : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    TemporaryFolderTest::SetUp();
    write_obj("cube.obj", box_mesh({1.0, 1.0, 1.0}, 2));
    ASSERT_EQ(rendered("[]", "").exit_code, 0) << "the scene that the others are made of";
    kept_ = contents();
  }

  ProcessResult rendered(const char* patch, const char* limit) const {
    io::write_text_atomically(folder() / "scene.json", scene(patch).dump());
    return kappamu(
        "render " + (folder() / "scene.json").string() + " -o " + (folder() / "out").string(),
        limit);
  }
  /// What lies in the folder of the picture, by name; the record of its files notes attempts.
  std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(folder() / "out")) {
      const std::string name = entry.path().filename().string();
      if (name != "kappamu-files.json") files[name] = io::read_text(entry.path());
    }
    return files;
  }

  void write_obj(const char* name, const TriangleMesh& mesh) const {
    std::ofstream file(folder() / name);
    for (const Eigen::Vector3d& v : mesh.vertices) file << "v " << v.transpose() << "\n";
    for (const auto& [a, b, c] : mesh.triangles) {
      file << "f " << a + 1 << " " << b + 1 << " " << c + 1 << "\n";
    }
  }
  /// A scene that is rendered, changed by a JSON patch (RFC 6902).
  static json scene(const char* patch) {
    return json::parse(R"({
      "format": "kappamu-scene", "version": 1,
      "objects": [{"name": "ball", "mesh": "cube.obj", "size_mm": 10,
                   "material": {"published": "skim milk"}}],
      "lights": [{"kind": "point", "position_mm": [0, 40, 40], "irradiance": 1, "at_mm": 50}],
      "camera": {"position_mm": [0, 0, 50], "target_mm": [0, 0, 0], "fov_deg": 16},
      "film": {"width": 8, "height": 8, "samples": 1},
      "model": {"name": "embedded", "tolerance": 0.5}})")
        .patch(json::parse(patch));
  }
  void expect_refused(const char* patch, const char* part) const {
    const ProcessResult result = rendered(patch, memory_limit);
    SCOPED_TRACE(patch);
    expect_one_sentence(result, part);
    EXPECT_TRUE(contents() == kept_) << "the older picture is not as it was";
  }

  std::map<std::string, std::string> kept_;
};

TEST_F(HostileScenes, AreRefusedInOneSentenceAndLoseNothing) {
  TriangleMesh broken = box_mesh({1.0, 1.0, 1.0}, 2);
  broken.vertices[5].y() = std::numeric_limits<double>::quiet_NaN();
  write_obj("nan.obj", broken);
  broken = box_mesh({1.0, 1.0, 1.0}, 2);
  broken.triangles.pop_back();
  write_obj("open.obj", broken);
  write_obj("point.obj", fitted(box_mesh({1.0, 1.0, 1.0}, 1), 1e-300));
  std::ofstream(folder() / "empty.obj").flush();
  {  // ten million triangles of STL, without the disk they would fill
    std::ofstream file(folder() / "many.stl", std::ios::binary);
    const std::uint32_t count = 10'000'000;
    file.seekp(80);
    file.write(reinterpret_cast<const char*>(&count), sizeof count);
  }
  fs::resize_file(folder() / "many.stl", 84 + 50ULL * 10'000'000);
  io::VolumeSet two;
  two.channels = {"R", "G"};
  const GridShape shape{2, 2, 2, 30.0};
  two.media.assign(2, {Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)});
  io::write_vdb(folder() / "two.vdb", two);
  two.channels = {"grey"};
  two.media.resize(1);
  io::write_vdb(folder() / "coarse.vdb", two);

  struct Hostile {
    const char *patch, *part;
  };
  const std::vector<Hostile> table{
      {R"([{"op": "replace", "path": "/objects/0/mesh", "value": "nan.obj"}])", "nan.obj"},
      {R"([{"op": "replace", "path": "/objects/0/mesh", "value": "open.obj"}])", "open.obj"},
      {R"([{"op": "replace", "path": "/objects/0/mesh", "value": "point.obj"}])", "point.obj"},
      {R"([{"op": "replace", "path": "/objects/0/mesh", "value": "empty.obj"}])", "empty.obj"},
      {R"([{"op": "replace", "path": "/objects/0/mesh", "value": "many.stl"}])",
       "more than 6000000 vertices"},
      {R"([{"op": "replace", "path": "/objects/0/mesh", "value": "absent.obj"}])", "absent.obj"},
      {R"([{"op": "replace", "path": "/objects/0/mesh", "value": "/dev/null"}])", "/dev/null"},
      {R"([{"op": "replace", "path": "/objects/0/size_mm", "value": 0}])", "size_mm"},
      {R"([{"op": "replace", "path": "/objects/0/size_mm", "value": 1e308}])", "size_mm"},
      {R"([{"op": "replace", "path": "/objects/0/size_mm", "value": [10, 0, 10]}])", "size_mm"},
      {R"([{"op": "remove", "path": "/objects/0/mesh"},
           {"op": "add", "path": "/objects/0/shape", "value": "dodecahedron"}])",
       "dodecahedron"},
      {R"([{"op": "replace", "path": "/objects/0/material/published", "value": "unobtainium"}])",
       "unobtainium"},
      {R"([{"op": "replace", "path": "/objects/0/material", "value": {"volume": "two.vdb"}}])",
       "no channel B"},
      {R"([{"op": "replace", "path": "/objects/0/material",
            "value": {"volume": "coarse.vdb", "placement": "repeat"}}])",
       "smaller than a voxel"},
      {R"([{"op": "replace", "path": "/objects/0/material", "value": {"volume": "absent"}}])",
       "absent"},
      {R"([{"op": "add", "path": "/objects/0/surface", "value": {"eta": 0.5}}])", "eta"},
      {R"([{"op": "replace", "path": "/objects/0/material",
            "value": {"mix": [{"published": "marble"}], "pattern": {"kind": "noise", "size_mm": 3}}}])",
       "mix"},
      {R"([{"op": "replace", "path": "/objects/0/material",
            "value": {"mix": [{"published": "marble"}, {"published": "potato"}],
                      "pattern": {"kind": "stripes", "size_mm": 3}}}])",
       "kind"},
      {R"([{"op": "replace", "path": "/objects/0/material",
            "value": {"mix": [{"published": "marble"}, {"published": "potato"}],
                      "pattern": {"kind": "noise", "size_mm": 3, "width": 0.1}}}])",
       "width"},
      {R"([{"op": "replace", "path": "/objects/0/material",
            "value": {"layers": [{"material": {"published": "skin1"}},
                                 {"material": {"published": "skin2"}}]}}])",
       "thickness_mm"},
      {R"([{"op": "replace", "path": "/objects/0/material",
            "value": {"around": {"published": "marble"},
                      "parts": [{"size_mm": 3, "material": {"published": "potato"}}]}}])",
       "'mesh' (a file) or 'shape' (a name)"},
      {R"([{"op": "replace", "path": "/objects/0/material",
            "value": {"subsurface": {"colour": [1, 1, 1], "radius_mm": 1}}}])",
       "colour"},
      {R"([{"op": "replace", "path": "/objects/0/material",
            "value": {"subsurface": {"colour": 0.5, "radius_mm": 1, "convention": "principled",
                                     "anisotropy": 0.5}}}])",
       "anisotropy"},
      {R"([{"op": "replace", "path": "/objects/0/material",
            "value": {"attenuation": {"colour": 0.5, "distance_mm": 3}}}])",
       "reduced_scattering_per_mm"},
      {R"([{"op": "replace", "path": "/objects/0/material",
            "value": {"file": "absent.glb", "reduced_scattering_per_mm": 1}}])",
       "absent.glb"},
      {R"([{"op": "replace", "path": "/objects/0/material",
            "value": {"published": "marble", "density": 0}}])",
       "density"},
      {R"([{"op": "add", "path": "/objects/-", "value": {"name": "other", "shape": "cube",
            "size_mm": 3, "material": {"published": "marble"}}}])",
       "overlap"},
      {R"([{"op": "replace", "path": "/lights/0/position_mm", "value": [0, 0, 1]},
           {"op": "add", "path": "/model", "value": {"name": "dipole"}}])",
       "from outside only"},
      {R"([{"op": "add", "path": "/objects/0/emission_per_mm", "value": -1}])", "emission_per_mm"},
      {R"([{"op": "add", "path": "/objects/0/surface", "value": {"bump": {"image": "white.png"}}}])",
       "depth_mm"},
      {R"([{"op": "add", "path": "/objects/0/surface",
            "value": {"bump": {"image": "white.png", "depth_mm": 0.1}}}])",
       "no texture coordinates"},
      {R"([{"op": "add", "path": "/objects/0/surface",
            "value": {"gloss": {"image": "absent.png", "roughness": [0.5, 0.1],
                                "size_mm": [9, 9]}}}])",
       "absent.png"},
      {R"([{"op": "add", "path": "/objects/0/surface",
            "value": {"reflectance": {"colour": 0.5, "size_mm": [9, 9]}}}])",
       "size_mm"},
      {R"([{"op": "add", "path": "/objects/0/surface",
            "value": {"reflectance": {"colour": [0.5, 2, 0.5]}}}])",
       "colour"},
      {R"([{"op": "replace", "path": "/lights/0", "value":
            {"kind": "spot", "position_mm": [0, 1, 0], "target_mm": [0, 9, 0], "cone_deg": 30,
             "irradiance": 1, "at_mm": 50}}])",
       "light 1 is inside object 'ball'"},
      {R"([{"op": "replace", "path": "/lights/0", "value":
            {"kind": "projector", "position_mm": [1, 0, 0], "target_mm": [9, 0, 0], "fov_deg": 30,
             "image": "white.png", "irradiance": 1, "at_mm": 50}}])",
       "light 1 is inside object 'ball'"},
      {R"([{"op": "replace", "path": "/lights/0/kind", "value": "laser"}])", "kind"},
      {R"([{"op": "replace", "path": "/lights/0/irradiance", "value": 1e300}])", "irradiance"},
      {R"([{"op": "replace", "path": "/lights/0", "value":
            {"kind": "environment", "radiance": 1, "image": "absent.exr"}}])",
       "absent.exr"},
      {R"([{"op": "replace", "path": "/camera/position_mm", "value": [0, 1, 1]}])",
       "the camera is inside object 'ball'"},
      {R"([{"op": "replace", "path": "/camera/target_mm", "value": [0, 0, 50]}])", "target_mm"},
      {R"([{"op": "replace", "path": "/film/width", "value": 1000000000}])", "width"},
      {R"([{"op": "replace", "path": "/film/samples", "value": 0}])", "samples"},
      {R"([{"op": "replace", "path": "/model/name", "value": "oracle"}])", "name"},
      {R"([{"op": "replace", "path": "/model/tolerance", "value": null}])", "tolerance"}};
  for (const Hostile& hostile : table) expect_refused(hostile.patch, hostile.part);
}

}  // namespace
}  // namespace kappamu::app
