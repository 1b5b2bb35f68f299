// `kappamu view` as a person would use it: a window under Xvfb, a script for hands, and the
// screenshots compared with each other and with `kappamu render` of the same state.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "io/read_file.h"
#include "io/volume/volume_file.h"
#include "process.h"
#include "render/linear_image.h"
#include "tests/app/tiny_session.h"

namespace kappamu::app {
namespace {

using nlohmann::json;

/// Of the objects' mean colour: what `kappamu render` adds is reflections (4 %) and the direction
/// of light scattered once.
constexpr double colour_tolerance = 0.15;

class ViewCommand : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    TemporaryFolderTest::SetUp();
    if (run_process("command -v xvfb-run").exit_code != 0) {
      GTEST_SKIP() << "xvfb-run is not there: the window is not tested";
    }
    const json scene{
        {"format", "kappamu-scene"},
        {"version", 1},
        {"objects",
         {{{"name", "ball"},
           {"shape", "sphere"},
           {"size_mm", 20},
           {"material", {{"published", "marble"}}},
           {"surface", {{"roughness", 0.5}}}}}},
        {"lights",
         {{{"kind", "directional"}, {"direction", {0, 0, -1}}, {"irradiance", {1, 0.8, 0.6}}}}},
        {"camera", {{"position_mm", {0, 0, 100}}, {"target_mm", {0, 0, 0}}, {"fov_deg", 16}}},
        {"film", {{"width", 96}, {"height", 64}, {"samples", 16}, {"exposure", 2.0}}},
        {"model", {{"name", "dipole-rotated"}}}};
    io::write_text_atomically(folder() / "scene.json", scene.dump());
  }

  ProcessResult view(const std::string& script, const std::string& options = "",
                     const std::string& display = "xvfb-run -a ") const {
    io::write_text_atomically(folder() / "script.txt", script);
    return run_process(display + KAPPAMU_PROGRAM " --json view " + path("scene.json") +
                       " --script " + path("script.txt") + " -o " + folder().string() + options);
  }
  std::string path(const char* name) const { return (folder() / name).string(); }

  /// Linear, over the disc of two thirds of the ball's radius.
  std::array<double, 3> mean_colour(const std::filesystem::path& file) const {
    const Image<std::uint16_t> codes = io::read_code_image(file);
    std::array<double, 3> sum{};
    int count = 0;
    for (int y = 0; y < codes.height(); ++y) {
      for (int x = 0; x < codes.width(); ++x) {
        if ((x - 48) * (x - 48) + (y - 32) * (y - 32) > 15 * 15) continue;
        ++count;
        for (int c = 0; c < 3; ++c) {
          sum[static_cast<std::size_t>(c)] += render::srgb_decoded(codes(x, y, c) / 255.0);
        }
      }
    }
    for (double& value : sum) value /= count;
    return sum;
  }
};

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

/// A block of measured material, edited by strokes and by a region, taken back, done again and
/// saved: pictures and files follow.
class ViewEdits : public ViewCommand {
 protected:
  void SetUp() override {
    ViewCommand::SetUp();
    if (IsSkipped()) return;
    const GridShape shape{12, 10, 6, 0.5};
    io::VolumeSet set;
    set.channels = {"R", "G", "B"};
    for (const double mu : {0.01, 0.02, 0.03}) {
      set.media.push_back({Volume<double>(shape, 0.3), Volume<double>(shape, mu)});
    }
    io::write_vdb(folder() / "volume.vdb", set);
    json scene = json::parse(io::read_text(folder() / "scene.json"));
    scene["objects"] = {{{"name", "block"},
                         {"shape", "cube"},
                         {"size_mm", {12, 10, 6}},
                         {"material", {{"volume", "volume.vdb"}, {"placement", "stretch"}}}}};
    scene["camera"]["position_mm"] = {0, 0, 60};
    // Aslant: the face would mirror the light into the camera, which the window does not show.
    scene["lights"][0]["direction"] = {-1, 0, -1};
    scene.erase("model");
    io::write_text_atomically(folder() / "scene.json", scene.dump());
    const json where{{"kind", "depth"}, {"from_mm", 0.0}, {"to_mm", 1.0}};
    const json edit{{"operation", "multiply"}, {"mu", 20}, {"channels", {"G"}}, {"where", where}};
    io::write_text_atomically(
        folder() / "skin.json",
        json{{"format", "kappamu-edit"}, {"version", 1}, {"edits", {edit}}}.dump());
  }

  std::vector<std::uint16_t> picture(const char* name) const {
    return io::read_code_image(folder() / name).values();
  }
  static int farthest(const std::vector<std::uint16_t>& one,
                      const std::vector<std::uint16_t>& other) {
    int most = 0;
    for (std::size_t i = 0; i < one.size(); ++i) most = std::max(most, std::abs(one[i] - other[i]));
    return most;
  }
  void expect_repeated_by_the_command_line() const {
    ASSERT_EQ(kappamu("edit " + path("scene.json") + " --recipe " + path("edited/recipe.json") +
                      " -o " + path("again"))
                  .exit_code,
              0);
    EXPECT_EQ(io::read_text(folder() / "again/volume.vdb"),
              io::read_text(folder() / "edited/volume.vdb"));
  }
};

TEST_F(ViewEdits, TakesBackAndSavesWhatTheCommandLineRepeats) {
  const ProcessResult result = view(
      "panel off\nscreenshot plain.png\nbrush multiply mu 20 3 4\npaint 40 32 56 32\nscreenshot "
      "painted.png\nundo\nscreenshot undone.png\nredo\nscreenshot redone.png\n"
      "preview skin.json\nscreenshot tried.png\ncancel\nscreenshot cancelled.png\n"
      "preview skin.json\nkeep\nscreenshot kept.png\nchannel G\nscreenshot green.png\n"
      "slice mu_R z 5\nsave\nquit\n",
      " --edits " + path("edited"));
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const json summary = json::parse(last_line(result.standard_output));
  EXPECT_EQ(summary["model"], "grid");
  EXPECT_EQ(summary["saved"].size(), 3);

  EXPECT_LT(mean_colour(folder() / "painted.png")[0], 0.8 * mean_colour(folder() / "plain.png")[0]);
  // Answers start from the last one, so that equal states agree to the tolerance of the equations.
  EXPECT_LE(farthest(picture("undone.png"), picture("plain.png")), 1);
  EXPECT_LE(farthest(picture("redone.png"), picture("painted.png")), 1);
  EXPECT_LE(farthest(picture("cancelled.png"), picture("painted.png")), 1);
  EXPECT_LE(farthest(picture("kept.png"), picture("tried.png")), 1);
  const auto painted = mean_colour(folder() / "painted.png"),
             kept = mean_colour(folder() / "kept.png"), green = mean_colour(folder() / "green.png");
  EXPECT_NEAR(kept[0], painted[0], 0.02 * painted[0]);
  EXPECT_LT(kept[1], 0.8 * painted[1]);
  for (const double channel : green) EXPECT_NEAR(channel, green[1], 1e-9);
  EXPECT_EQ(json::parse(io::read_text(folder() / "edited/recipe.json"))["edits"].size(), 2U);
  expect_repeated_by_the_command_line();

  // The saved volume in place of the first: what the window and `kappamu render` show of it.
  json scene = json::parse(io::read_text(folder() / "scene.json"));
  scene["objects"][0]["material"]["volume"] = "edited/volume.vdb";
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  ASSERT_EQ(view("panel off\nscreenshot reopened.png\nquit\n").exit_code, 0);
  EXPECT_LE(farthest(picture("reopened.png"), picture("kept.png")), 2);
  ASSERT_EQ(kappamu("render " + path("scene.json") + " -o " + path("out")).exit_code, 0);
  const auto rendered = mean_colour(folder() / "out" / "picture.png");
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(kept[c], rendered[c], colour_tolerance * rendered[c]) << c;
  }
}

/// A window continues from what the last one saved in the same folder, undone edits included.
TEST_F(ViewEdits, ContinuesFromWhatWasSaved) {
  const std::string edits = " --edits " + path("edited"), stroke = "paint 40 32 56 32\n";
  const auto saved_edits = [&] {
    return json::parse(io::read_text(folder() / "edited/recipe.json"))["edits"].size();
  };
  const ProcessResult first = view("brush multiply mu 20 3 4\n" + stroke + "save\n", edits);
  if (first.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << first.standard_error;
  }
  ASSERT_EQ(first.exit_code, 0) << first.standard_error;
  ASSERT_EQ(view("brush set kappa 0.5 2 2\n" + stroke + "save\n", edits).exit_code, 0);
  EXPECT_EQ(saved_edits(), 2U);
  expect_repeated_by_the_command_line();

  ASSERT_EQ(view("undo\nundo\nsave\n", edits).exit_code, 0);
  EXPECT_EQ(saved_edits(), 0U);
  const io::VolumeSet plain = io::read_volume(folder() / "volume.vdb"),
                      undone = io::read_volume(folder() / "edited/volume.vdb");
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(undone.media[c].mu.values(), plain.media[c].mu.values());
  }
}

TEST_F(ViewEdits, RefusesWhatARecipeOrAFolderCannotHold) {
  const auto refused = [&](const std::string& brush, const std::string& part) {
    // Before there is a window.
    expect_one_sentence(
        view(brush + "\npaint 40 32 56 32\nsave\n", " --edits " + path("edited"), ""), part);
    EXPECT_FALSE(std::filesystem::exists(folder() / "edited")) << brush;
  };
  const ProcessResult plain = view("quit\n");
  if (plain.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << plain.standard_error;
  }
  refused("brush multiply mu -5 3 4", "script.txt: line 1: this edit: mu is -5");
  refused("brush set kappa 0 3 4", "kappa is 0");
  refused("brush multiply mu 2000000 3 4", "mu");
  // A folder that cannot be saved into.
  io::write_text_atomically(folder() / "taken", "a file");
  expect_one_sentence(view("quit\n", " --edits " + path("taken"), ""), "taken");
  // The edits of another volume.
  ASSERT_EQ(
      view("brush multiply mu 20 3 4\npaint 40 32 56 32\nsave\n", " --edits " + path("edited"))
          .exit_code,
      0);
  io::VolumeSet other = io::read_volume(folder() / "volume.vdb");
  for (Medium& medium : other.media) medium.mu(0, 0, 0) *= 2.0;
  io::write_vdb(folder() / "volume.vdb", other);
  expect_one_sentence(view("quit\n", " --edits " + path("edited"), ""), "another volume");
}

/// What the papers edit: a homogeneous object, by a stroke of the brush and a preset. The window
/// leaves what the command line makes of the same recipe, and `kappamu render` shows it.
TEST_F(ViewEdits, EditsAHomogeneousObject) {
  json scene = json::parse(io::read_text(folder() / "scene.json"));
  scene["objects"] = {{{"name", "ball"},
                       {"shape", "sphere"},
                       {"size_mm", 20},
                       {"material", {{"published", "marble"}}}}};
  scene["camera"]["position_mm"] = {0, 0, 100};
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  const json all{{"operation", "set"}, {"published", "skin1"}, {"where", {{"kind", "all"}}}};
  io::write_text_atomically(
      folder() / "skin.json",
      json{{"format", "kappamu-edit"}, {"version", 1}, {"edits", {all}}}.dump());
  const ProcessResult result = view(
      "panel off\nscreenshot plain.png\npreview skin.json\nkeep\nscreenshot skin.png\n"
      "brush multiply mu 20 3 3\npaint 40 32 56 32\nscreenshot painted.png\nsave\nquit\n",
      " --edits " + path("edited"));
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  EXPECT_LT(mean_colour(folder() / "skin.png")[2], 0.8 * mean_colour(folder() / "plain.png")[2]);
  EXPECT_LT(mean_colour(folder() / "painted.png")[0], 0.9 * mean_colour(folder() / "skin.png")[0]);
  expect_repeated_by_the_command_line();
  EXPECT_EQ(json::parse(io::read_text(folder() / "again/scene.json")),
            json::parse(io::read_text(folder() / "edited/scene.json")));
}

/// Beside the volume's own box, where it lies mirrored: the stroke edits what is seen there.
TEST_F(ViewEdits, PaintsOnAMirroredVolume) {
  json scene = json::parse(io::read_text(folder() / "scene.json"));
  scene["objects"][0]["material"]["placement"] = "mirror";
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  // The block of 12 x 10 x 6 mm holds the volume of 6 x 5 x 3 mm two times along each axis.
  const ProcessResult result =
      view("brush multiply mu 20 1 2\npaint 20 32 30 32\nsave\n", " --edits " + path("edited"));
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const io::VolumeSet plain = io::read_volume(folder() / "volume.vdb"),
                      edited = io::read_volume(folder() / "edited/volume.vdb");
  EXPECT_NE(edited.media[0].mu.values(), plain.media[0].mu.values());
  expect_repeated_by_the_command_line();
}

/// Killed while it saves again and again, at several moments after the first time.
TEST_F(ViewEdits, KilledLeavesAWholeRecipeAndVolume) {
  std::string script = "panel off\nbrush multiply mu 1.1 1 1\n";
  for (int stroke = 0; stroke < 300; ++stroke) script += "paint 40 32 56 32\nsave\n";
  const std::string window = "view " + path("scene.json") + " --script " + path("script.txt") +
                             " -o " + folder().string() + " --edits " + path("edited");
  if (view("quit\n").standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << "the window is not there";
  }
  io::write_text_atomically(folder() / "script.txt", script + "quit\n");
  // One screen for all windows; what each leaves is kept as left-MOMENT.
  const std::vector<std::string> moments{"0", "0.003", "0.013", "0.029", "0.071", "0.11"};
  std::string kill = "cd " + folder().string() + "\n";
  for (const std::string& moment : moments) {
    kill += "rm -rf edited\n" KAPPAMU_PROGRAM " " + window + " & window=$!\n" +
            "while [ ! -e edited/recipe.json ]; do\n" +
            "  kill -0 $window || exit 9; sleep 0.002; done\n" + "sleep " + moment +
            "\nkill -KILL $window || exit 8; wait $window\ncp -r edited left-" + moment + "\n";
  }
  io::write_text_atomically(folder() / "kill.sh", kill + "exit 0\n");
  ASSERT_EQ(run_process("xvfb-run -a sh " + path("kill.sh")).exit_code, 0);
  for (const std::string& moment : moments) {
    const std::filesystem::path left = folder() / ("left-" + moment);
    EXPECT_GE(json::parse(io::read_text(left / "recipe.json"))["edits"].size(), 1U) << moment;
    EXPECT_EQ(io::read_volume(left / "volume.vdb").shape().nx, 12) << moment;
  }
  // And the folder takes the next saving.
  ASSERT_EQ(
      view("brush multiply mu 2 1 1\npaint 40 32 56 32\nsave\nquit\n", " --edits " + path("edited"))
          .exit_code,
      0);
  expect_repeated_by_the_command_line();
}

// By the window's own path: a shape that deforms, by a list and by a drag, and one that it does not
// bear.
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
    return run_process("xvfb-run -a " KAPPAMU_PROGRAM " --json view " + path("rod.json") +
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
class ViewAsRender : public ViewCommand, public testing::WithParamInterface<const char*> {};

TEST_P(ViewAsRender, ShowsTheSamePicture) {
  json scene =
      json::parse(io::read_text(KAPPAMU_SOURCE_DIR "/scenes/" + std::string(GetParam()) + ".json"));
  for (json& object : scene["objects"]) {
    if (!object.contains("mesh")) continue;
    object["mesh"] = KAPPAMU_SOURCE_DIR "/scenes/" + object["mesh"].get<std::string>();
  }
  scene["film"] = {{"width", 80}, {"height", 60}, {"samples", 16}, {"exposure", 1.5}};
  scene["model"] = {{"name", "polygrid"}, {"tolerance", 0.1}};
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  const ProcessResult viewed = view("panel off\nscreenshot seen.png\nquit\n");
  if (viewed.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << viewed.standard_error;
  }
  ASSERT_EQ(viewed.exit_code, 0) << viewed.standard_error;
  ASSERT_EQ(kappamu("render " + path("scene.json") + " -o " + path("out")).exit_code, 0);
  const json window = json::parse(last_line(viewed.standard_output)),
             render = json::parse(io::read_text(folder() / "out/summary.json"));
  double stated =
      std::hypot(window["error_estimate"].get<double>(),
                 window["model_error"].is_null() ? 0.0 : window["model_error"].get<double>());
  for (const json& object : render["objects"]) {
    for (const json& channel : object["channels"]) {
      stated = std::max(stated, channel["error"].get<double>());
    }
  }
  const Image<std::uint16_t> seen = io::read_code_image(folder() / "seen.png"),
                             drawn = io::read_code_image(folder() / "out/picture.png");
  ASSERT_TRUE(seen.same_shape(drawn));
  double difference = 0.0, all = 0.0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const double one = render::srgb_decoded(seen.values()[i] / 255.0),
                 other = render::srgb_decoded(drawn.values()[i] / 255.0);
    difference += std::abs(one - other);
    all += other;
  }
  RecordProperty("difference", std::to_string(difference / all));
  RecordProperty("stated", std::to_string(stated));
  EXPECT_GT(all, 0.0);
  EXPECT_LT(difference, stated * all) << GetParam();
}

INSTANTIATE_TEST_SUITE_P(Scenes, ViewAsRender,
                         testing::Values("bob-back-lit", "spot-milk", "spot-wax", "bump", "ring"));

/// Of a run: the photographs of its patterns, beside what the volume predicts.
TEST_F(ViewCommand, ShowsARunsPhotographs) {
  const auto viewed = [&](const std::string& script) {
    io::write_text_atomically(folder() / "script.txt", script);
    return run_process("xvfb-run -a " KAPPAMU_PROGRAM " view " + tiny_run().string() +
                       " --script " + path("script.txt") + " -o " + folder().string());
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
