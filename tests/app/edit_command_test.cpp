// `kappamu edit` from outside: files, equal bits, ownership, exit codes. What edits do is tested in
// tests/render/edit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "io/npy.h"
#include "io/read_file.h"
#include "io/volume/volume_file.h"
#include "tests/app/process.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;

class EditCommand : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    TemporaryFolderTest::SetUp();
    const GridShape shape{6, 5, 4, 0.5};
    io::VolumeSet set;
    set.channels = {"R", "G"};
    for (int c = 0; c < 2; ++c) {
      set.media.push_back({Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)});
    }
    set.eta = 1.3;
    io::write_vdb(folder() / "run" / "fit" / "volume.vdb", set);
    write_recipe(R"({"operation": "multiply", "mu": 3, "channels": ["G"],
      "where": {"kind": "brush", "radius_mm": 1, "depth_mm": 1,
                "strokes": [{"points_mm": [[1, 1, 2], [2, 1.5, 2]], "inward": [[0, 0, -1]]}]}})");
  }
  void write_recipe(const std::string& edit) const {
    io::write_text_atomically(
        folder() / "r.json",
        R"({"format": "kappamu-edit", "version": 1, "edits": [)" + edit + "]}");
  }
  std::string path(const char* name) const { return (folder() / name).string(); }
  ProcessResult edit(const char* out) const {
    return kappamu("--json edit --recipe " + path("r.json") + " " + path("run") + " -o " +
                   path(out));
  }
};

TEST_F(EditCommand, ReplaysToEqualBitsAndEveryExporterTakesIt) {
  ASSERT_EQ(edit("a").exit_code, 0);
  ASSERT_EQ(edit("b").exit_code, 0);
  EXPECT_EQ(io::read_text(folder() / "a" / "volume.vdb"),
            io::read_text(folder() / "b" / "volume.vdb"));
  EXPECT_EQ(io::read_text(folder() / "a" / "recipe.json"),
            io::read_text(folder() / "b" / "recipe.json"));
  const io::VolumeSet set = io::read_volume(io::find_volume(folder() / "a"));
  EXPECT_FLOAT_EQ(static_cast<float>(set.media[1].mu(3, 2, 3)), 0.03F);
  EXPECT_FLOAT_EQ(static_cast<float>(set.media[0].mu(3, 2, 3)), 0.01F);
  EXPECT_EQ(kappamu("verify " + path("a")).exit_code, 0);
  ASSERT_EQ(kappamu("export " + path("a") + " -o " + path("x")).exit_code, 0);
  for (const char* name : {"volume.vti", "volume.vdb", "mitsuba/scene.xml", "exr/slice_003.exr"}) {
    EXPECT_TRUE(fs::exists(folder() / "x" / name)) << name;
  }
  const io::NpyArray mu = io::read_npy(folder() / "x" / "npy" / "mu_G.npy", {4, 5, 6});
  for (std::size_t i = 0; i < mu.values.size(); ++i) {
    EXPECT_EQ(static_cast<float>(mu.values[i]), static_cast<float>(set.media[1].mu[i])) << i;
  }
}

/// A run's volume is left as it was.
TEST_F(EditCommand, LeavesItsInputAlone) {
  const std::string before = io::read_text(folder() / "run" / "fit" / "volume.vdb");
  ASSERT_EQ(edit("a").exit_code, 0);
  EXPECT_EQ(io::read_text(folder() / "run" / "fit" / "volume.vdb"), before);
  expect_one_sentence(edit("run"), "run");
  expect_one_sentence(edit("run/fit/inside"), "inside");
}

/// An edited volume is a volume: it can be edited and rendered.
TEST_F(EditCommand, ScenesTakeWhatItWrites) {
  ASSERT_EQ(edit("a").exit_code, 0);
  io::write_text_atomically(folder() / "grey.json", R"({"format": "kappamu-edit", "version": 1,
    "edits": [{"operation": "set", "mu": 0.02, "channels": ["G"], "where": {"kind": "all"}}]})");
  ASSERT_EQ(kappamu("edit --recipe " + path("grey.json") + " " + path("a") + " -o " + path("b"))
                .exit_code,
            0);
  EXPECT_FLOAT_EQ(
      static_cast<float>(io::read_volume(folder() / "b" / "volume.vdb").media[1].mu(3, 2, 3)),
      0.02F);
  io::VolumeSet grey = io::read_volume(folder() / "b" / "volume.vdb");
  grey.channels = {"grey"};
  grey.media.resize(1);
  io::write_vdb(folder() / "grey" / "volume.vdb", grey);
  write_recipe(R"({"operation": "multiply", "mu": 2, "where": {"kind": "all"}})");
  ASSERT_EQ(kappamu("edit --recipe " + path("r.json") + " " + path("grey") + " -o " + path("c"))
                .exit_code,
            0);
  io::write_text_atomically(folder() / "scene.json", R"({"format": "kappamu-scene", "version": 1,
    "objects": [{"name": "block", "shape": "cube", "size_mm": 3, "material": {"volume": "c"}}],
    "lights": [{"kind": "environment", "radiance": 0.1}],
    "camera": {"position_mm": [0, 0, 20], "target_mm": [0, 0, 0], "fov_deg": 16},
    "film": {"width": 8, "height": 8, "samples": 1}, "model": {"name": "embedded", "tolerance": 0.2}})");
  const ProcessResult result = kappamu("render " + path("scene.json") + " -o " + path("picture"));
  EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 3) << result.standard_error;
  EXPECT_TRUE(fs::exists(folder() / "picture" / "picture.png"));
}

/// The recipe it leaves does again what it did, its images included.
TEST_F(EditCommand, ItsOwnRecipeIsReplayed) {
  Image<std::uint8_t> leaf(3, 2, 3);
  for (int c = 0; c < 3; ++c) leaf(1, 1, c) = 200;
  fs::create_directories(folder() / "images");
  io::write_image(folder() / "images" / "leaf.png", leaf);
  write_recipe(R"({"operation": "blend", "share": 0.5, "kappa": 1, "where": {"kind": "texture",
    "image": "images/leaf.png", "face": "z+", "depth_mm": 1}})");
  ASSERT_EQ(edit("a").exit_code, 0);
  EXPECT_NE(io::read_text(folder() / "a" / "volume.vdb"),
            io::read_text(folder() / "run" / "fit" / "volume.vdb"));
  ASSERT_EQ(
      kappamu("edit --recipe " + path("a/recipe.json") + " " + path("run") + " -o " + path("b"))
          .exit_code,
      0);
  EXPECT_EQ(io::read_text(folder() / "a" / "volume.vdb"),
            io::read_text(folder() / "b" / "volume.vdb"));
}

/// A scene's object of every kind: what is written is a scene that `kappamu render` shows, and the
/// same again by its own recipe.
TEST_F(EditCommand, EditsObjectsOfScenes) {
  fs::create_directories(folder() / "scenes");
  const auto scene_of = [&](const std::string& material) {
    io::write_text_atomically(folder() / "scenes" / "scene.json",
                              R"({"format": "kappamu-scene", "version": 1, "_comment": "a ball",
    "objects": [{"name": "ball", "shape": "sphere", "size_mm": 20, "material": )" +
                                  material + R"(}],
    "lights": [{"kind": "environment", "radiance": 0.1}],
    "camera": {"position_mm": [0, 0, 80], "target_mm": [0, 0, 0], "fov_deg": 16},
    "film": {"width": 8, "height": 8, "samples": 1}, "model": {"name": "dipole-rotated"}})");
  };
  const auto edit_scene = [&](const std::string& more, const char* out) {
    return kappamu("edit " + path("scenes/scene.json") + " --recipe " + path("r.json") + more +
                   " -o " + path(out));
  };
  write_recipe(R"({"operation": "multiply", "mu": 30, "channels": ["R", "G", "B"],
    "where": {"kind": "depth", "frame": "object", "from_mm": 0, "to_mm": 1.5}})");
  for (const char* material :
       {R"({"published": "marble"})", R"({"kappa_mm": 0.3, "mu_per_mm": [0.01, 0.02, 0.03]})",
        R"({"volume": "../rgb.vdb", "placement": "repeat"})",
        R"({"volume": "../rgb.vdb", "placement": "mirror", "turn_deg": [30, 0, 0]})"}) {
    io::VolumeSet rgb = io::read_volume(folder() / "run" / "fit" / "volume.vdb");
    rgb.channels = {"R", "G", "B"};
    rgb.media.push_back(rgb.media.back());
    rgb.eta.reset();
    io::write_vdb(folder() / "rgb.vdb", rgb);
    scene_of(material);
    const ProcessResult first = edit_scene(" --voxel 0.9", "a");
    ASSERT_EQ(first.exit_code, 0) << material << first.standard_error;
    ASSERT_EQ(kappamu("edit " + path("scenes/scene.json") + " --recipe " + path("a/recipe.json") +
                      " -o " + path("b"))
                  .exit_code,
              0);
    EXPECT_EQ(io::read_text(folder() / "a" / "volume.vdb"),
              io::read_text(folder() / "b" / "volume.vdb"))
        << material;
    const auto scene = nlohmann::json::parse(io::read_text(folder() / "a" / "scene.json"));
    EXPECT_EQ(scene["_comment"], "a ball");
    EXPECT_EQ(scene["objects"][0]["material"]["volume"], "volume.vdb");
    EXPECT_EQ(scene["model"]["name"], "embedded");
  }
  // All of a homogeneous object: it stays one, and its model too.
  scene_of(R"({"published": "marble"})");
  write_recipe(R"({"operation": "set", "albedo": [0.8, 0.5, 0.3], "where": {"kind": "all"}},
    {"operation": "surface", "roughness": 0.7})");
  ASSERT_EQ(edit_scene("", "whole").exit_code, 0);
  EXPECT_FALSE(fs::exists(folder() / "whole" / "volume.vdb"));
  const auto scene = nlohmann::json::parse(io::read_text(folder() / "whole" / "scene.json"));
  EXPECT_EQ(scene["objects"][0]["surface"]["roughness"], 0.7);
  EXPECT_EQ(scene["objects"][0]["surface"]["eta"], 1.5);
  EXPECT_EQ(scene["model"]["name"], "dipole-rotated");
  const ProcessResult picture = kappamu("render " + path("whole/scene.json") + " -o " + path("p"));
  EXPECT_TRUE(picture.exit_code == 0 || picture.exit_code == 3) << picture.standard_error;
  expect_one_sentence(edit_scene(" --object bowl", "out"),
                      "has no object 'bowl'; name one of ball");
  write_recipe(R"({"operation": "multiply", "mu": 2, "where": {"kind": "box", "frame": "object",
    "from_mm": [0, 0, 0], "to_mm": [1, 1, 1]}})");
  // A volume by itself is a block whose frame begins in its middle: 3 x 2.5 x 2 mm.
  ASSERT_EQ(edit("block").exit_code, 0);
  const io::VolumeSet block = io::read_volume(folder() / "block" / "volume.vdb");
  EXPECT_FLOAT_EQ(static_cast<float>(block.media[0].mu(3, 3, 2)), 0.02F);
  EXPECT_FLOAT_EQ(static_cast<float>(block.media[0].mu(2, 3, 2)), 0.01F);
  expect_one_sentence(edit_scene(" --voxel 0.001", "out"), "are too many");
}

/// What is written keeps the recipe of the other object, whose lights would undo the change.
TEST_F(EditCommand, RefusesLightsThatAnotherObjectsRecipeSets) {
  const auto write_lights = [&](const char* name, const char* lights) {
    io::write_text_atomically(
        folder() / name,
        std::string(R"({"format": "kappamu-edit", "version": 1, "edits": [], "lights": [)") +
            lights + "]}");
  };
  write_lights("other.json", R"({"light": 1, "turn_deg": 30})");
  io::write_text_atomically(folder() / "scene.json", R"({"format": "kappamu-scene", "version": 1,
    "objects": [{"name": "a", "shape": "sphere", "size_mm": 20, "material": {"published": "marble"}},
                {"name": "b", "shape": "sphere", "size_mm": 20, "position_mm": [40, 0, 0],
                 "material": {"published": "marble"}, "edits": "other.json"}],
    "lights": [{"kind": "environment", "radiance": 0.1}],
    "camera": {"position_mm": [0, 0, 80], "target_mm": [0, 0, 0], "fov_deg": 16},
    "film": {"width": 8, "height": 8, "samples": 1}, "model": {"name": "dipole-rotated"}})");
  const auto edit_scene = [&](const char* object, const char* out) {
    return kappamu("edit " + path("scene.json") + " --object " + object + " --recipe " +
                   path("r.json") + " -o " + path(out));
  };
  write_lights("r.json", R"({"light": 1, "turn_deg": 50})");
  expect_one_sentence(edit_scene("a", "refused"),
                      "other.json: light 1: 'turn_deg' is another one in the edits of object 'a'");
  EXPECT_FALSE(fs::exists(folder() / "refused" / "scene.json"));
  ASSERT_EQ(edit_scene("b", "own").exit_code, 0);
  const auto own = nlohmann::json::parse(io::read_text(folder() / "own" / "scene.json"));
  EXPECT_EQ(own["lights"][0]["turn_deg"], 50);
  write_lights("r.json", R"({"light": 1, "radiance": [0.2, 0.2, 0.2]})");
  ASSERT_EQ(edit_scene("a", "both").exit_code, 0);
  EXPECT_EQ(kappamu("render " + path("both/scene.json") + " -o " + path("p")).exit_code % 3, 0);
}

TEST_F(EditCommand, RefusesInOneSentenceAndLeavesNothing) {
  write_recipe(
      R"({"operation": "multiply", "mu": 3, "channels": ["X"], "where": {"kind": "all"}})");
  expect_one_sentence(edit("out"), "edit 1: the volume has no channel X");
  write_recipe(R"({"operation": "multiply", "mu": 3, "where": {"kind": "texture", "image": "no.png",
    "face": "z+", "depth_mm": 1}})");
  expect_one_sentence(edit("out"), "no.png");
  io::write_text_atomically(folder() / "text.png", "no image");
  write_recipe(
      R"({"operation": "multiply", "mu": 3, "where": {"kind": "texture", "image": "text.png",
    "face": "z+", "depth_mm": 1}})");
  expect_one_sentence(edit("out"), "text.png");
  write_recipe(R"({"operation": "multiply", "mu": 3, "where": {"kind": "brush", "radius_mm": 1e-6,
    "depth_mm": 1, "strokes": [{"points_mm": [[0, 0, 2], [3, 0, 2]], "inward": [[0, 0, -1]]}]}})");
  expect_one_sentence(edit("out"), "edit 1: the strokes are more than 250,000 radii long");
  write_recipe("}");
  expect_one_sentence(edit("out"), "r.json");
  write_recipe(R"({"operation": "multiply", "mu": -3, "where": {"kind": "all"}})");
  expect_one_sentence(edit("out"), "edits[0].mu is -3");
  expect_one_sentence(
      kappamu("edit --recipe " + path("absent.json") + " " + path("run") + " -o " + path("out")),
      "absent.json");
  write_recipe(R"({"operation": "multiply", "mu": 3, "where": {"kind": "all"}})");
  expect_one_sentence(
      kappamu("edit --recipe " + path("r.json") + " " + path("absent") + " -o " + path("out")),
      "absent");
  const fs::path volume = folder() / "run" / "fit" / "volume.vdb";
  fs::resize_file(volume, fs::file_size(volume) / 2);
  expect_one_sentence(edit("out"), "volume.vdb");
  EXPECT_FALSE(fs::exists(folder() / "out"));
}

TEST_F(EditCommand, WarnsOfWhatIsHeldAtItsBounds) {
  write_recipe(R"({"operation": "add", "mu": -1, "where": {"kind": "all"}})");
  const ProcessResult result = edit("a");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(last_line(result.standard_output),
              testing::HasSubstr("edit 1: coefficients held at their bounds"));
}

TEST_F(EditCommand, WarnsOfLightsWhereThereAreNone) {
  io::write_text_atomically(folder() / "r.json",
                            R"({"format": "kappamu-edit", "version": 1, "edits": [],
                                "lights": [{"light": 1, "irradiance": [1, 2, 3]}]})");
  const ProcessResult result = edit("a");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.standard_error, testing::HasSubstr("its lights are of a scene"));
}

/// Files that are not the command's stay as they are.
TEST_F(EditCommand, ReplacesItsOwnFilesAlone) {
  ASSERT_EQ(edit("a").exit_code, 0);
  ASSERT_EQ(edit("a").exit_code, 0);
  io::write_text_atomically(folder() / "b" / "recipe.json", "mine");
  EXPECT_EQ(edit("b").exit_code, 1);
  EXPECT_EQ(io::read_text(folder() / "b" / "recipe.json"), "mine");
  EXPECT_FALSE(fs::exists(folder() / "b" / "volume.vdb"));
}

}  // namespace
}  // namespace kappamu::app
