// Scenes over time: which values fields take at a frame, and what is refused.
#include "render/scene/frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

using nlohmann::json;

class FramesFile : public testing::Test {
 protected:
  void SetUp() override {
    write("scene.json", json::parse(R"({"format": "kappamu-scene", "version": 1,
      "objects": [{"name": "rod", "shape": "cylinder", "size_mm": 30, "material": {"published": "marble"},
                   "deform": [{"kind": "twist", "degrees": 0}]},
                  {"name": "dancer", "mesh": "none.obj", "size_mm": 10, "material": {"published": "marble"}}],
      "lights": [{"kind": "point", "position_mm": [0, 50, 0], "irradiance": 1, "at_mm": 50}],
      "camera": {"position_mm": [0, 0, 90], "target_mm": [0, 0, 10], "fov_deg": 30},
      "film": {"width": 8, "height": 8}})"));
  }
  std::filesystem::path write(const char* name, const json& content) const {
    std::ofstream(folder_ / name) << content.dump();
    return folder_ / name;
  }
  static json track(const char* field, const json& keys) {
    return {{"field", field}, {"keys", keys}};
  }
  Frames frames(const json& tracks) const {
    return {folder_ / "scene.json", write("frames.json", {{"format", "kappamu-frames"},
                                                          {"version", 1},
                                                          {"frames", 11},
                                                          {"rate", 12.5},
                                                          {"tracks", tracks}})};
  }
  std::string refusal(const json& tracks) const {
    return sentence_of([&] { frames(tracks); }, "");
  }
  const OwnFolder folder_;
};

TEST_F(FramesFile, NumbersGoEvenlyFromKeyToKeyAndStayBeyondThem) {
  json smooth = track("camera.fov_deg", {{0, 20}, {10, 30}});
  smooth["between"] = "smooth";
  const Frames made =
      frames({track("objects[0].deform[0].degrees", {{2, 10}, {6, 90}}),
              track("lights[0].position_mm", {{0, {0, 50, 0}}, {10, {10, 50, -20}}}), smooth});
  EXPECT_EQ(made.count(), 11);
  EXPECT_EQ(made.rate(), 12.5);
  const auto degrees = [&](int frame) { return made.scene(frame).objects[0].deform[0].amount; };
  EXPECT_EQ(degrees(0), 10.0);
  EXPECT_EQ(degrees(2), 10.0);
  EXPECT_DOUBLE_EQ(degrees(3), 30.0);
  EXPECT_EQ(degrees(6), 90.0);
  EXPECT_EQ(degrees(10), 90.0);
  const auto at = std::get<PointLight>(made.scene(4).lights[0]).position_mm;
  EXPECT_LT((at - Eigen::Vector3d(4.0, 50.0, -8.0)).norm(), 1e-12);
  EXPECT_NEAR(made.scene(5).camera.fov_deg, 25.0, 1e-12);
  EXPECT_LT(made.scene(1).camera.fov_deg, 20.5);  // starts slowly
  EXPECT_EQ(made.scene(7).objects[1].name, "dancer");
}

TEST_F(FramesFile, TextsStepAndSequencesCount) {
  json step = track("objects[0].material.published", {{0, "marble"}, {5, "whole milk"}});
  step["between"] = "step";
  const Frames made =
      frames({step, {{"field", "objects[1].mesh"}, {"files", "walk-###.obj"}, {"first", 98}}});
  const auto name = [&](int frame) {
    return std::get<std::filesystem::path>(made.scene(frame).objects[1].shape).filename().string();
  };
  EXPECT_EQ(name(0), "walk-098.obj");
  EXPECT_EQ(name(10), "walk-108.obj");
  const auto kappa = [&](int frame) {
    return std::get<HomogeneousMaterial>(made.scene(frame).objects[0].material).kappa_mm;
  };
  EXPECT_TRUE((kappa(0) == kappa(4)).all());
  EXPECT_FALSE((kappa(4) == kappa(5)).all());
}

TEST_F(FramesFile, ATurntableKeepsTheDistanceAndEndsBeforeItBegins) {
  const Frames made(folder_ / "scene.json", 8);
  Eigen::Vector3d before = made.scene(7).camera.position_mm;
  for (int frame = 0; frame < 8; ++frame) {
    const Camera camera = made.scene(frame).camera;
    EXPECT_NEAR((camera.position_mm - camera.target_mm).norm(), 80.0, 1e-9);
    EXPECT_NEAR(camera.position_mm.y(), 0.0, 1e-9);
    // Steps are chords of 45 degrees.
    EXPECT_NEAR((camera.position_mm - before).norm(), 160.0 * std::sin(0.392699081698724), 1e-9);
    before = camera.position_mm;
  }
}

TEST_F(FramesFile, RefusesByFileFrameAndField) {
  const auto refused = [&](const json& tracks, const std::string& text) {
    EXPECT_THAT(refusal(tracks), testing::HasSubstr(text));
  };
  refused(json::array({track("objects[4].size_mm", {{0, 1}})}), "tracks[0].field is no field of");
  refused(json::array({track("nothing.at_all", {{0, 1}})}), "tracks[0].field is no field of");
  refused(json::array({track("camera.fov_deg", {{3, 20}, {3, 30}})}),
          "tracks[0].keys[1][0] is not after");
  refused(json::array({track("camera.fov_deg", {{0, 20}, {3, "wide"}})}),
          "tracks[0].keys[1][1] does not go on");
  refused(json::array({{{"field", "objects[1].mesh"}, {"files", "walk.obj"}}}), "has no run of #");
  refused(json::array({{{"field", "objects[1].mesh"}}}), "must have either 'keys' or 'files'");
  refused(json::array(), "tracks has 0 entries");
  const Frames wide = frames(json::array({track("camera.fov_deg", {{0, 20}, {10, 400}})}));
  EXPECT_NO_THROW(wide.scene(1));
  const std::string sentence = sentence_of([&] { wide.scene(9); });
  EXPECT_THAT(sentence, testing::HasSubstr("scene.json at frame 9: camera.fov_deg is 362"));
}

}  // namespace
}  // namespace kappamu::render
