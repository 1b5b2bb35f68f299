// `kappamu render` from outside: files, exit codes, balance. What is in the pictures is tested in
// tests/render.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "io/npy.h"
#include "io/read_file.h"
#include "io/volume/volume_file.h"
#include "process.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double balance_tolerance = 1e-5;  // relative: power in = deposited + unscattered

class RenderCommand : public TemporaryFolderTest {
 protected:
  std::string path(const char* name) const { return (folder() / name).string(); }
  void write_scene(const std::string& model) const {
    json scene{
        {"format", "kappamu-scene"},
        {"version", 1},
        {"objects",
         {{{"name", "ball"},
           {"shape", "sphere"},
           {"size_mm", 10},
           {"material", {{"published", "skim milk"}}}}}},
        {"lights",
         {{{"kind", "directional"}, {"direction", {0, -1, -1}}, {"irradiance", {1, 0.9, 0.8}}},
          {{"kind", "environment"}, {"radiance", 0.1}}}},
        {"camera", {{"position_mm", {0, 0, 50}}, {"target_mm", {0, 0, 0}}, {"fov_deg", 16}}},
        {"film", {{"width", 16}, {"height", 12}, {"samples", 4}}},
        {"model", {{"name", model}, {"tolerance", 0.2}}}};
    if (model != "embedded" && model != "polygrid") scene["model"]["photons"] = 20000;
    io::write_text_atomically(folder() / "scene.json", scene.dump());
  }
};

TEST_F(RenderCommand, WritesPictureExitanceAndBalance) {
  for (const std::string model : {"embedded", "montecarlo", "auto"}) {
    write_scene(model);
    const ProcessResult result =
        kappamu("--json render " + path("scene.json") + " -o " + path("out"));
    ASSERT_TRUE(result.exit_code == 0 || result.exit_code == 3) << result.standard_error;
    const json summary = json::parse(last_line(result.standard_output));
    EXPECT_EQ(summary, json::parse(io::read_text(folder() / "out" / "summary.json")));
    EXPECT_EQ(summary["converged"], result.exit_code == 0);
    const json& object = summary["objects"][0];
    EXPECT_EQ(object.contains("candidates"), model == "auto");
    if (model == "auto") {
      EXPECT_GT(object["candidates"].size(), 3U);
      for (const json& candidate : object["candidates"]) {
        EXPECT_FALSE(candidate["reason"].get<std::string>().empty());
      }
      EXPECT_LE(object["candidates"][0]["error"].get<double>(), 0.2);
    }
    const std::size_t samples = object["samples"];
    const io::NpyArray exitance = io::read_npy(folder() / "out" / "exitance.npy", {3, samples});
    const io::NpyArray error = io::read_npy(folder() / "out" / "error.npy", {3, samples});
    const json& green = object["channels"][1];
    EXPECT_GE(green["error"], green["error_estimate"]);
    EXPECT_FLOAT_EQ(
        *std::max_element(error.values.begin() + static_cast<std::ptrdiff_t>(samples),
                          error.values.begin() + static_cast<std::ptrdiff_t>(2 * samples)),
        green["error_map"]["max"].get<float>());
    const io::NpyArray surface = io::read_npy(folder() / "out" / "surface.npy", {samples, 7});
    for (std::size_t c = 0; c < 3; ++c) {
      const json& channel = object["channels"][c];
      const double entering = channel["entering"];
      EXPECT_NEAR(entering,
                  channel["unscattered"].get<double>() + channel["out"].get<double>() +
                      channel["absorbed"].get<double>(),
                  balance_tolerance * entering)
          << model;
      EXPECT_NEAR(channel["power_in"].get<double>(), entering + channel["reflected"].get<double>(),
                  balance_tolerance * entering);
      double out = 0.0;
      for (std::size_t t = 0; t < samples; ++t) {
        out += exitance.values[c * samples + t] * surface.values[7 * t + 6];
      }
      EXPECT_NEAR(out, channel["out"].get<double>(), 1e-3 * out) << model;
    }
    const io::ExrImage exr = io::read_exr(folder() / "out" / "picture.exr");
    EXPECT_EQ(exr.width, 16);
    EXPECT_EQ(exr.channels.at("A")[6 * 16 + 8], 1.0F);
    EXPECT_GT(exr.channels.at("R")[6 * 16 + 8], 0.0F);
    EXPECT_EQ(io::read_code_image(folder() / "out" / "picture.png").height(), 12);
  }
}

TEST_F(RenderCommand, ACameraThatSeesNoObjectIsTold) {
  write_scene("embedded");
  json scene = json::parse(io::read_text(folder() / "scene.json"));
  scene["camera"]["target_mm"] = {0, 0, 100};
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  const ProcessResult result = kappamu("render " + path("scene.json") + " -o " + path("out"));
  EXPECT_THAT(result.standard_error,
              ::testing::HasSubstr("no pixel shows an object: the camera looks at (0, 0, 100) mm, "
                                   "and object 'ball' lies about"));
}

TEST_F(RenderCommand, NewSceneOfARunIsRendered) {
  const GridShape shape{8, 6, 4, 0.5};
  io::VolumeSet set;
  set.channels = {"grey"};
  set.media.push_back({Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)});
  set.eta = 1.3;
  io::write_vdb(folder() / "run" / "fit" / "volume.vdb", set);
  ASSERT_EQ(kappamu("render --new-scene " + path("run") + " -o " + path("scene.json")).exit_code,
            0);
  json scene = json::parse(io::read_text(folder() / "scene.json"));
  // As in the manual page: both names without a folder.
  ASSERT_EQ(
      kappamu("render --new-scene run -o here.json", "cd " + folder().string() + " &&").exit_code,
      0);
  EXPECT_EQ(json::parse(io::read_text(folder() / "here.json")), scene);
  EXPECT_TRUE(scene.contains("_comment"));
  scene["film"] = {{"width", 8}, {"height", 6}, {"samples", 1}};
  scene["model"]["tolerance"] = 0.3;
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  const ProcessResult result = kappamu("render " + path("scene.json") + " -o " + path("out"));
  EXPECT_EQ(result.exit_code, 0) << result.standard_error;
  EXPECT_TRUE(fs::exists(folder() / "out" / "picture.png"));
}

TEST_F(RenderCommand, WritesAPolycubeAndTakesADrawnOne) {
  write_scene("polygrid");
  const std::string ask = "--json render " + path("scene.json") + " --polycube ball -o ";
  const ProcessResult found = kappamu(ask + path("found.json"));
  ASSERT_EQ(found.exit_code, 0) << found.standard_error;
  EXPECT_GT(json::parse(last_line(found.standard_output))["polycube_cells"], 100);

  json scene = json::parse(io::read_text(folder() / "scene.json"));
  scene["objects"][0]["polycube"] = "drawn.json";
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  io::write_text_atomically(
      folder() / "drawn.json",
      R"({"format": "kappamu-polycube", "version": 1, "origin_mm": [-3, -3, -3], "edge_mm": 6,
          "boxes": [{"from": [0, 0, 0], "to": [0, 0, 0]}]})");
  const ProcessResult drawn = kappamu(ask + path("moved.json"));
  ASSERT_EQ(drawn.exit_code, 0) << drawn.standard_error;
  const json quality = json::parse(last_line(drawn.standard_output));
  EXPECT_EQ(quality["polycube_cells"], 1);
  EXPECT_GE(quality["least_jacobian"], 0.2);
  EXPECT_EQ(json::parse(io::read_text(folder() / "moved.json"))["boxes"].size(), 1U);
  const ProcessResult rendered =
      kappamu("--json render " + path("scene.json") + " -o " + path("out"));
  ASSERT_TRUE(rendered.exit_code == 0 || rendered.exit_code == 3) << rendered.standard_error;
  const json summary = json::parse(last_line(rendered.standard_output));
  // The polygrid of the command, split in eight once or more.
  const int cells = summary["objects"][0]["channels"][1]["elements"];
  EXPECT_EQ(cells % (8 * quality["cells"].get<int>()), 0) << cells;

  expect_one_sentence(kappamu(ask + path("moved.json")), "moved.json");
  expect_one_sentence(
      kappamu("render " + path("scene.json") + " --polycube bowl -o " + path("x.json")),
      "has no object 'bowl'; write one of ball");
  scene["objects"][0]["size_mm"] = 100;
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  expect_one_sentence(kappamu("render " + path("scene.json") + " -o " + path("large")),
                      "drawn.json: the polycube lies off the object or is of another size");
  scene["objects"][0]["shape"] = "torus";
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  expect_one_sentence(kappamu("render " + path("scene.json") + " -o " + path("torus")),
                      "drawn.json: the polycube has genus 0, the mesh 1");
}

TEST_F(RenderCommand, RefusesInOneSentence) {
  write_scene("embedded");
  json scene = json::parse(io::read_text(folder() / "scene.json"));
  scene["camera"]["position_mm"] = {0, 0, 1};
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  expect_one_sentence(kappamu("render " + path("scene.json") + " -o " + path("out")),
                      "the camera is inside object 'ball'");
  EXPECT_FALSE(fs::exists(folder() / "out"));
  expect_one_sentence(kappamu("render " + path("absent.json") + " -o " + path("out")),
                      "absent.json");
  expect_one_sentence(kappamu("render --new-scene gold -o " + path("s.json")), "whole milk");
  EXPECT_EQ(kappamu("render -o " + path("out")).exit_code, 2);
}

// Frames that are there of the same inputs stay; a change renders those that it concerns alone.
TEST_F(RenderCommand, FramesGoOnWhereTheyWereAndFollowTheirInputs) {
  write_scene("dipole-rotated");
  const auto write_frames = [&](int last) {
    io::write_text_atomically(
        folder() / "frames.json",
        json{{"format", "kappamu-frames"},
             {"version", 1},
             {"frames", 3},
             {"tracks",
              {{{"field", "camera.position_mm"},
                {"keys", {{0, {0, 0, 50}}, {1, {0, 0, 49}}, {2, {0, 0, last}}}}}}}}
            .dump());
  };
  const auto render = [&] {
    const ProcessResult result = kappamu("--json render " + path("scene.json") + " --frames " +
                                         path("frames.json") + " -o " + path("film"));
    EXPECT_EQ(result.exit_code, 0) << result.standard_error;
    return json::parse(last_line(result.standard_output));
  };
  json scene = json::parse(io::read_text(folder() / "scene.json"));
  scene["model"].erase("photons");
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  write_frames(48);
  EXPECT_EQ(render()["rendered"], 3);
  EXPECT_EQ(render()["kept"], 3);
  write_frames(40);
  const json changed = render();
  EXPECT_EQ(changed["rendered"], 1);
  EXPECT_EQ(changed["kept"], 2);
  std::vector<json> summaries;
  for (const char* name : {"frame-00000", "frame-00001", "frame-00002"}) {
    EXPECT_TRUE(fs::exists(folder() / "film" / (name + std::string(".png"))));
    summaries.push_back(
        json::parse(io::read_text(folder() / "film" / (name + std::string(".json")))));
  }
  EXPECT_EQ(summaries[0]["picture"]["exposure"], summaries[2]["picture"]["exposure"]);

  // An attempt that ends at a frame that cannot be keeps those before it.
  io::write_text_atomically(folder() / "bad.json", R"({"format": "kappamu-frames", "version": 1,
      "frames": 3, "tracks": [{"field": "camera.position_mm",
                               "keys": [[0, [0, 0, 60]], [1, [0, 0, 30]], [2, [0, 0, 2]]]}]})");
  const ProcessResult bad = kappamu("render " + path("scene.json") + " --frames " +
                                    path("bad.json") + " -o " + path("other"));
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_THAT(bad.standard_error,
              testing::HasSubstr("frame 2: the camera is inside object 'ball'"));
  EXPECT_TRUE(fs::exists(folder() / "other" / "frames.partial" / "frame-00001.png"));
}

TEST_F(RenderCommand, ATurntableIsAsManyPictures) {
  write_scene("embedded");
  const ProcessResult result = kappamu("--json render " + path("scene.json") +
                                       " --model dipole-rotated --turntable 2 -o " + path("turn"));
  EXPECT_EQ(result.exit_code, 0) << result.standard_error;
  EXPECT_EQ(json::parse(last_line(result.standard_output))["frames"], 2);
  EXPECT_TRUE(fs::exists(folder() / "turn" / "frame-00001.png"));
  EXPECT_FALSE(fs::exists(folder() / "turn" / "frame-00002.png"));
}

}  // namespace
}  // namespace kappamu::app
