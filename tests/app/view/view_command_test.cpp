// Screenshots of the window, compared with each other and with `kappamu render` of the same state.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "io/read_file.h"
#include "tests/app/tiny_session.h"
#include "tests/app/view/view_command.h"

namespace kappamu::app {
namespace {

using nlohmann::json;

TEST_F(ViewCommand, ShowsWhatRenderShowsAndFollowsTheLight) {
  const ProcessResult result = view(
      "panel off\nscreenshot front.png\nlight 150 20  # behind\nscreenshot back.png\n"
      "orbit 90 0\nscreenshot side.png\nlight 0 0\norbit -90 0\nscreenshot again.png\nquit\n");
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const json summary = json::parse(last_line(result.standard_output));
  EXPECT_GE(summary["answers"].get<int>(), 3);  // of moved lights, and better ones of each
  EXPECT_GT(summary["first_picture_s"].get<double>(), 0.0);
  EXPECT_GE(summary["first_light_s"].get<double>(), summary["first_picture_s"].get<double>());
  EXPECT_EQ(summary["screenshots"].size(), 4);
  EXPECT_LT(summary["error_estimate"].get<double>(), 0.02);

  ASSERT_EQ(kappamu("render " + path("scene.json") + " -o " + path("out")).exit_code, 0);
  const auto rendered = mean_colour(folder() / "out" / "picture.png");
  const auto front = mean_colour(folder() / "front.png"), back = mean_colour(folder() / "back.png"),
             side = mean_colour(folder() / "side.png");
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_GT(front[c], 0.05);
    EXPECT_NEAR(front[c], rendered[c], colour_tolerance * rendered[c]) << c;
    EXPECT_LT(back[c], 0.7 * front[c]) << c;
    EXPECT_GT(side[c], 1.1 * back[c]) << c;
  }
  // The light turned back is the first one but for its last digits: one code of 255 at most.
  const Image<std::uint16_t> again = io::read_code_image(folder() / "again.png"),
                             first = io::read_code_image(folder() / "front.png");
  ASSERT_TRUE(again.same_shape(first));
  int largest = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    largest = std::max(largest, std::abs(int{again.values()[i]} - int{first.values()[i]}));
  }
  EXPECT_LE(largest, 1);
}

TEST_F(ViewCommand, ScriptsDeformObjects) {
  io::write_text_atomically(folder() / "rod.json", R"({"format": "kappamu-scene", "version": 1,
      "objects": [{"name": "rod", "shape": "cylinder", "proportion": 0.2, "size_mm": 30,
                   "material": {"published": "marble"}}],
      "lights": [{"kind": "directional", "direction": [0, 0, -1], "irradiance": 1}],
      "camera": {"position_mm": [0, 0, 120], "target_mm": [0, 0, 0], "fov_deg": 18},
      "film": {"width": 64, "height": 64}})");
  const auto list = [&](const char* name, int degrees) {
    io::write_text_atomically(
        folder() / name,
        json{{{"kind", "bend"}, {"degrees", degrees}, {"axis", {0, 0, 1}}}}.dump());
  };
  list("some.json", 60);
  list("much.json", 360);
  const auto viewed = [&](const std::string& script) {
    io::write_text_atomically(folder() / "script.txt", script);
    return run_process(on_a_screen + KAPPAMU_PROGRAM " --json view " + path("rod.json") +
                       " --script " + path("script.txt") + " -o " + folder().string());
  };
  const ProcessResult result = viewed(
      "panel off\nscreenshot rest.png\ndeform rod some.json moving\ndeform rod some.json\n"
      "screenshot bent.png\ndrag pull 32 32 34 31 4\nscreenshot pulled.png\nlinks anew\n"
      "deform rod some.json\nscreenshot again.png\n");
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const json summary = json::parse(last_line(result.standard_output));
  EXPECT_GT(summary["shape_ms"]["incremental"], 0.0);
  EXPECT_GT(summary["shape_ms"]["on the fly"], 0.0);
  const auto picture = [&](const char* name) {
    return io::read_code_image(folder() / name).values();
  };
  EXPECT_NE(picture("rest.png"), picture("bent.png"));
  EXPECT_NE(picture("bent.png"), picture("pulled.png"));
  EXPECT_THAT(viewed("deform rod much.json\n").standard_error,
              testing::HasSubstr("deform[0], bend of 360 degrees, makes the surface cross itself"));
  EXPECT_THAT(viewed("deform cone some.json\n").standard_error,
              testing::HasSubstr("there is no object 'cone'"));
}

/// A deformation is an edit: saved in the recipe, undone and redone, and made again by the command
/// line to the last byte, in a scene that `kappamu render` takes.
TEST_F(ViewCommand, ShapesAreEdits) {
  const std::string edits = " --edits " + path("edited");
  const auto recipe = [&] { return json::parse(io::read_text(folder() / "edited/recipe.json")); };
  const ProcessResult first = view(
      "drag pull 48 32 52 30 6\nundo\nredo\nbrush multiply mu 20 3 3\npaint 48 20 48 24\nsave\n",
      edits);
  if (first.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << first.standard_error;
  }
  ASSERT_EQ(first.exit_code, 0) << first.standard_error;
  ASSERT_EQ(recipe()["edits"].size(), 2U);
  EXPECT_EQ(recipe()["edits"][0]["operation"], "deform");
  EXPECT_EQ(recipe()["edits"][0]["deform"][0]["kind"], "pull");
  ASSERT_EQ(kappamu("edit " + path("scene.json") + " --recipe " + path("edited/recipe.json") +
                    " -o " + path("again"))
                .exit_code,
            0);
  for (const char* file : {"scene.json", "volume.vdb", "recipe.json"}) {
    EXPECT_EQ(io::read_text(folder() / "again" / file), io::read_text(folder() / "edited" / file))
        << file;
  }
  EXPECT_EQ(json::parse(io::read_text(folder() / "edited/scene.json"))["objects"][0]["deform"],
            recipe()["edits"][0]["deform"]);
  // The next window continues from it, and can take it back.
  ASSERT_EQ(view("undo\nundo\nsave\n", edits).exit_code, 0);
  EXPECT_TRUE(recipe()["edits"].empty());
  EXPECT_FALSE(
      json::parse(io::read_text(folder() / "edited/scene.json"))["objects"][0].contains("deform"));
}

/// Shipped scenes, coarsely: at rest the window's picture is that of `kappamu render`, but for what
/// both state of their exitance and for noise. Both draw the same rays.
class AsRender : public ViewCommand {
 protected:
  /// Of what the graphics card draws while things move: 0.027 to 0.040 were measured.
  static constexpr double drawn_tolerance = 0.06;

  static json shipped(const std::string& name) {
    const std::string scenes = KAPPAMU_SOURCE_DIR "/scenes/";
    json scene = json::parse(io::read_text(scenes + name + ".json"));
    for (json& object : scene["objects"]) {
      if (object.contains("mesh")) object["mesh"] = scenes + object["mesh"].get<std::string>();
    }
    scene["film"] = {{"width", 80}, {"height", 60}, {"samples", 16}, {"exposure", 1.5}};
    scene["model"] = {{"name", "polygrid"}, {"tolerance", 0.1}};
    return scene;
  }
  void write(const json& scene) const {
    io::write_text_atomically(folder() / "scene.json", scene.dump());
  }
  /// The scene that was written, after some lines of a script: at rest in seen.png, and as it is
  /// drawn while things move in moving.png. Skips the test where there is no window.
  void take_pictures(const std::string& lines = "", const std::string& options = "") {
    const ProcessResult viewed = view("panel off\n" + lines +
                                          "screenshot seen.png\ntrace off\n"
                                          "screenshot moving.png\nquit\n",
                                      options);
    if (viewed.standard_error.find("built without its window") != std::string::npos) {
      GTEST_SKIP() << viewed.standard_error;
    }
    ASSERT_EQ(viewed.exit_code, 0) << viewed.standard_error;
    window_ = json::parse(last_line(viewed.standard_output));
  }
  /// Of both pictures from that of `kappamu render` of the scene that is written now.
  void compare(const char* name) {
    if (IsSkipped() || HasFatalFailure()) return;
    ASSERT_EQ(kappamu("render " + path("scene.json") + " -o " + path("out")).exit_code, 0);
    at_rest_ = difference("seen.png");
    while_moving_ = difference("moving.png");
    std::printf("%s: at rest %.4f, while things move %.4f\n", name, at_rest_, while_moving_);
  }

  /// Mean absolute difference from `kappamu render`, linear, over its mean.
  double difference(const char* file) const {
    const Image<std::uint16_t> one = io::read_code_image(folder() / file),
                               other = io::read_code_image(folder() / "out/picture.png");
    if (!one.same_shape(other)) throw std::runtime_error("pictures of two shapes");
    double sum = 0.0, all = 0.0;
    for (std::size_t i = 0; i < one.size(); ++i) {
      const double drawn = render::srgb_decoded(other.values()[i] / 255.0);
      sum += std::abs(render::srgb_decoded(one.values()[i] / 255.0) - drawn);
      all += drawn;
    }
    return sum / all;
  }

  json window_;
  double at_rest_ = 0.0, while_moving_ = 0.0;
};

class ViewAsRender : public AsRender, public testing::WithParamInterface<const char*> {};

TEST_P(ViewAsRender, ShowsTheSamePicture) {
  write(shipped(GetParam()));
  take_pictures();
  compare(GetParam());
  if (IsSkipped() || HasFatalFailure()) return;
  const json render = json::parse(io::read_text(folder() / "out/summary.json"));
  double stated =
      std::hypot(window_["error_estimate"].get<double>(),
                 window_["model_error"].is_null() ? 0.0 : window_["model_error"].get<double>());
  for (const json& object : render["objects"]) {
    for (const json& channel : object["channels"]) {
      stated = std::max(stated, channel["error"].get<double>());
    }
  }
  std::printf("stated %.4f\n", stated);
  EXPECT_LT(at_rest_, stated);
  EXPECT_LT(while_moving_, drawn_tolerance);
}

INSTANTIATE_TEST_SUITE_P(Scenes, ViewAsRender,
                         testing::Values("bob-back-lit", "spot-milk", "spot-wax", "bump", "ring"));

/// What the five scenes have little of: a sky with lamps that a glossy surface mirrors, and light
/// that the tone curve bends.
TEST_F(AsRender, ShowsTheSameReflectionsAndToneCurve) {
  json scene = shipped("spot-milk");
  scene["objects"][0]["surface"] = {{"roughness", 0.05}, {"eta", 1.5}};
  scene["lights"][2] = {{"kind", "environment"},
                        {"radiance", 0.3},
                        {"visible", false},
                        {"image", KAPPAMU_SOURCE_DIR "/scenes/maps/studio.png"}};
  scene["film"]["exposure"] = 2.5;
  write(scene);
  take_pictures();
  compare("reflections");
  if (IsSkipped() || HasFatalFailure()) return;
  // As many pixels as that of the object are beyond the curve's straight part.
  const Image<std::uint16_t> picture = io::read_code_image(folder() / "out/picture.png");
  int object = 0, bent = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      int brightest = 0;
      for (int c = 0; c < 3; ++c) brightest = std::max(brightest, int{picture(x, y, c)});
      object += brightest > 4 ? 1 : 0;
      bent += render::srgb_decoded(brightest / 255.0) > 0.6 ? 1 : 0;
    }
  }
  // The image's lamps, against even light of the same scene.
  scene["lights"][2].erase("image");
  write(scene);
  ASSERT_EQ(kappamu("render " + path("scene.json") + " -o " + path("even")).exit_code, 0);
  std::filesystem::copy_file(folder() / "even/picture.png", folder() / "even.png");
  const double sky = difference("even.png");
  std::printf("%d of %d pixels bent, sky %.4f\n", bent, object, sky);
  EXPECT_GT(bent, object / 20);
  EXPECT_GT(sky, 0.1);
  EXPECT_LT(at_rest_, 0.02);
  EXPECT_LT(while_moving_, 0.1);
}

/// A dim sky with one wide lamp behind a body: its light enters along its own directions, as
/// `kappamu render` has it. As even light it would be 2 to 6 % darker.
TEST_F(AsRender, ShowsTheSameUnderAWideLamp) {
  constexpr int rows = 36, columns = 72;
  Image<float> sky(columns, rows, 3, 0.05F);
  for (int y = 12; y < 22; ++y) {
    for (int x = 30; x < 42; ++x) {
      for (int c = 0; c < 3; ++c) sky(x, y, c) = 4.0F;
    }
  }
  io::write_float_image(folder() / "sky.exr", sky);
  json scene = shipped("bob-back-lit");
  scene["lights"] = {
      {{"kind", "environment"}, {"image", "sky.exr"}, {"radiance", 1}, {"visible", false}}};
  write(scene);
  take_pictures();
  compare("wide lamp");
  if (IsSkipped() || HasFatalFailure()) return;
  EXPECT_LT(at_rest_, 0.015);
  // What is drawn has no lamp seen through thin parts, and reflects it along contours in its own
  // way.
  EXPECT_LT(while_moving_, 0.16);
}

/// A light inside a body, which takes part in a twist and in a change of colour.
TEST_F(AsRender, ShowsLightThatBeginsInside) {
  json scene = shipped("candle-solid");
  scene["film"]["width"] = 60;
  scene["film"]["height"] = 80;
  const json twist = scene["objects"][0]["deform"];
  scene["objects"][0].erase("deform");
  write(scene);
  io::write_text_atomically(folder() / "twist.json", twist.dump());
  take_pictures("brightness 1 1 6\ndeform candle twist.json moving\ndeform candle twist.json\n");
  scene["objects"][0]["deform"] = twist;
  scene["lights"][0]["irradiance"] = {1, 1, 6};
  write(scene);
  compare("inner light");
  if (IsSkipped() || HasFatalFailure()) return;
  EXPECT_LT(at_rest_, 0.03);
  EXPECT_LT(while_moving_, drawn_tolerance);
}

/// Where a body's rim lies before the body itself, rims of drawn pixels are no darker than traced
/// ones beside them, but for what a pixel's width blurs.
TEST_F(AsRender, HasNoDarkPixelsAlongContours) {
  json scene = shipped("bob-back-lit");
  scene["film"]["width"] = 480;
  scene["film"]["height"] = 360;
  scene["model"]["name"] = "dipole-rotated";
  write(scene);
  take_pictures("", " --model dipole-rotated");
  if (IsSkipped() || HasFatalFailure()) return;
  const Image<std::uint16_t> traced = io::read_code_image(folder() / "seen.png"),
                             drawn = io::read_code_image(folder() / "moving.png");
  ASSERT_TRUE(traced.same_shape(drawn));
  const auto bright = [](const Image<std::uint16_t>& image, int x, int y) {
    return int{image(x, y, 0)} + int{image(x, y, 1)} + int{image(x, y, 2)};
  };
  int darker = 0, most = 0;  // than all traced pixels around, of 765
  for (int y = 1; y + 1 < drawn.height(); ++y) {
    for (int x = 1; x + 1 < drawn.width(); ++x) {
      int least = 765;
      for (int i = 0; i < 9; ++i)
        least = std::min(least, bright(traced, x + i % 3 - 1, y + i / 3 - 1));
      const int by = least - bright(drawn, x, y);
      darker += by > 30 ? 1 : 0;
      most = std::max(most, by);
    }
  }
  std::printf("darker than traced by more than 30 of 765: %d pixels, at most %d\n", darker, most);
  EXPECT_LE(darker, 20);  // 29 where cosines are taken at one place of a pixel
  EXPECT_LE(most, 60);    // 78 there
}

/// Of a run: the photographs of its patterns, beside what the volume predicts.
TEST_F(ViewCommand, ShowsARunsPhotographs) {
  const auto viewed = [&](const std::string& script) {
    io::write_text_atomically(folder() / "script.txt", script);
    return run_process(on_a_screen + KAPPAMU_PROGRAM " view " + tiny_run().string() + " --script " +
                       path("script.txt") + " -o " + folder().string());
  };
  const ProcessResult result = viewed("screenshot plain.png\nphotograph 1\nscreenshot shown.png\n");
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  EXPECT_NE(io::read_code_image(folder() / "shown.png").values(),
            io::read_code_image(folder() / "plain.png").values());
  EXPECT_THAT(viewed("photograph 99\n").standard_error,
              testing::HasSubstr("photograph: there are"));
}

TEST_F(ViewCommand, RefusesAPictureThatNoDriverHolds) {
  auto scene = nlohmann::json::parse(io::read_text(folder() / "scene.json"));
  scene["film"]["width"] = 16;
  scene["film"]["height"] = 16384;
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  const ProcessResult result = view("trace off\nscreenshot tall.png\n", " --width 256");
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  expect_one_sentence(result, "256 x 262144 px; take a smaller width");
  EXPECT_FALSE(std::filesystem::exists(folder() / "tall.png"));
}

TEST_F(ViewCommand, RefusesAScriptInOneSentence) {
  // Before a window is opened: no display is needed.
  const auto refused = [&](const std::string& script) { return view(script, "", ""); };
  const ProcessResult result = refused("panel off\nlight up\n");
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  expect_one_sentence(result, "script.txt: line 2");
  expect_one_sentence(refused("screenshot ../outside.png\n"), "script.txt: line 1");
  io::write_text_atomically(folder() / "mine.png", "mine");
  expect_one_sentence(refused("screenshot mine.png\n"), "mine.png: exists already");
  EXPECT_EQ(io::read_text(folder() / "mine.png"), "mine");
}

}  // namespace
}  // namespace kappamu::app
