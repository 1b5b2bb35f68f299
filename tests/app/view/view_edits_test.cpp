// Edits in the window: painted, taken back, done again and saved; pictures and files follow.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "io/read_file.h"
#include "io/volume/volume_file.h"
#include "tests/app/view/view_command.h"

namespace kappamu::app {
namespace {

using nlohmann::json;

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
    // As much as voxels of the window's grid resolve: beyond that `kappamu render` refines them.
    const json edit{{"operation", "multiply"}, {"mu", 4}, {"channels", {"G"}}, {"where", where}};
    io::write_text_atomically(
        folder() / "skin.json",
        json{{"format", "kappamu-edit"}, {"version", 1}, {"edits", {edit}}}.dump());
  }

  /// A homogeneous object in place of the block.
  void show_a_ball() const {
    json scene = json::parse(io::read_text(folder() / "scene.json"));
    scene["objects"] = {{{"name", "ball"},
                         {"shape", "sphere"},
                         {"size_mm", 20},
                         {"material", {{"published", "marble"}}}}};
    scene["camera"]["position_mm"] = {0, 0, 100};
    io::write_text_atomically(folder() / "scene.json", scene.dump());
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
  show_a_ball();
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

/// The stroke that made a volume of it is undone: the dipole answers again.
TEST_F(ViewEdits, AnObjectWhoseStrokeIsUndoneIsHomogeneousAgain) {
  show_a_ball();
  const std::string stroke = "brush multiply mu 20 3 3\npaint 40 32 56 32\n";
  const std::string edits = " --edits " + path("edited");
  const ProcessResult painted = view("trace off\n" + stroke + "save\n", edits);
  if (painted.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << painted.standard_error;
  }
  ASSERT_EQ(painted.exit_code, 0) << painted.standard_error;
  EXPECT_TRUE(std::filesystem::exists(folder() / "edited/volume.vdb"));
  // A model for homogeneous objects is refused while it is a volume, and answers after the undo.
  EXPECT_NE(view("model dipole-rotated\n", edits).exit_code, 0);
  const ProcessResult undone = view("undo\nmodel dipole-rotated\nsave\n", edits);
  ASSERT_EQ(undone.exit_code, 0) << undone.standard_error;
  EXPECT_EQ(json::parse(last_line(undone.standard_output))["model"], "dipole-rotated");
  EXPECT_FALSE(std::filesystem::exists(folder() / "edited/volume.vdb"));
  EXPECT_TRUE(
      json::parse(io::read_text(folder() / "edited/scene.json"))["objects"][0]["material"].contains(
          "kappa_mm"));
}

/// Lights that were turned and coloured are saved with the edits: the next window, `kappamu render`
/// and `kappamu edit` have them.
TEST_F(ViewEdits, SavesTurnedLights) {
  json scene = json::parse(io::read_text(folder() / "scene.json"));
  scene["lights"].push_back({{"kind", "environment"}, {"radiance", 0.05}});
  scene["lights"].push_back(
      {{"kind", "point"}, {"position_mm", {0, 30, 0}}, {"irradiance", 0.2}, {"at_mm", 30}});
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  const std::string edits = " --edits " + path("edited");
  const auto saved = [&](const char* file) {
    return json::parse(io::read_text(folder() / "edited" / file));
  };
  const ProcessResult first = view(
      "panel off\nlight 60 30\nlamp 2\nturn 40\nbrightness 0.02 0.03 0.04\nlamp 3\n"
      "brightness 0.5 0.1 0\nlight 0 0\nundo\ndistance 50\nscreenshot turned.png\nsave\n",
      edits);
  if (first.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << first.standard_error;
  }
  ASSERT_EQ(first.exit_code, 0) << first.standard_error;
  const json lights = saved("scene.json")["lights"];
  EXPECT_NEAR(lights[0]["direction"][1].get<double>(), -0.5, 1e-9);
  EXPECT_EQ(lights[1]["turn_deg"], 40.0);
  EXPECT_EQ(lights[1]["radiance"], (json{0.02, 0.03, 0.04}));
  EXPECT_NEAR(lights[2]["position_mm"][1].get<double>(), 50.0, 1e-9);
  EXPECT_EQ(lights[2]["irradiance"], (json{0.5, 0.1, 0.0}));
  EXPECT_EQ(saved("recipe.json")["lights"].size(), 3U);
  EXPECT_TRUE(saved("recipe.json")["edits"].empty());
  expect_repeated_by_the_command_line();
  EXPECT_EQ(io::read_text(folder() / "again/scene.json"),
            io::read_text(folder() / "edited/scene.json"));

  // The next window begins with them, and can take them back; beside them an edit is saved.
  const ProcessResult next = view(
      "panel off\nscreenshot back.png\nbrush multiply mu 20 3 4\npaint 40 32 56 32\nsave\n", edits);
  ASSERT_EQ(next.exit_code, 0) << next.standard_error;
  EXPECT_LE(farthest(picture("back.png"), picture("turned.png")), 1);
  EXPECT_EQ(saved("recipe.json")["edits"].size(), 1U);
  EXPECT_EQ(saved("scene.json")["lights"], lights);
  ASSERT_EQ(view("undo\nundo\nsave\n", edits).exit_code, 0);
  EXPECT_FALSE(saved("recipe.json").contains("lights"));
  EXPECT_EQ(saved("scene.json")["lights"], scene["lights"]);

  // Of a scene with other lights they are refused.
  json recipe{{"format", "kappamu-edit"}, {"version", 1}, {"edits", json::array()}};
  recipe["lights"] = {{{"light", 7}, {"turn_deg", 1}}};
  io::write_text_atomically(folder() / "lights.json", recipe.dump());
  expect_one_sentence(kappamu("edit " + path("scene.json") + " --recipe " + path("lights.json") +
                              " -o " + path("never")),
                      "light 7 is not there");
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
  ASSERT_EQ(run_process(on_a_screen + "sh " + path("kill.sh")).exit_code, 0);
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

/// Two states in one picture, with one camera and one light: only the right one is edited.
TEST_F(ViewEdits, ShowsTwoStatesSideBySide) {
  const ProcessResult result = view(
      "panel off\ncompare unedited\nscreenshot both.png\nbrush multiply mu 20 3 4\n"
      "paint 64 32 80 32\nscreenshot painted.png\nlight 30 20\nscreenshot turned.png\n"
      "compare now\nscreenshot kept.png\nundo\nundo\nlight 30 20\nscreenshot undone.png\ncompare "
      "off\n"
      "screenshot single.png\n");
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const auto half = [&](const char* name, bool right) {
    const Image<std::uint16_t> whole = io::read_code_image(folder() / name);
    std::vector<std::uint16_t> codes;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 48; ++x) {
        for (int c = 0; c < 3; ++c) codes.push_back(whole(right ? 48 + x : x, y, c));
      }
    }
    return codes;
  };
  const auto left = [&](const char* name) { return half(name, false); };
  const auto right = [&](const char* name) { return half(name, true); };
  EXPECT_LE(farthest(left("both.png"), right("both.png")), 1);
  EXPECT_LE(farthest(left("painted.png"), left("both.png")), 1);
  EXPECT_GT(farthest(right("painted.png"), right("both.png")), 20);
  EXPECT_GT(farthest(left("turned.png"), left("painted.png")), 20);
  EXPECT_GT(farthest(right("turned.png"), left("turned.png")), 20);
  EXPECT_LE(farthest(left("kept.png"), right("turned.png")), 1);
  EXPECT_LE(farthest(left("undone.png"), left("kept.png")), 1);
  EXPECT_LE(farthest(right("undone.png"), left("turned.png")), 1);
  EXPECT_GT(farthest(picture("single.png"), picture("undone.png")), 20);
}

}  // namespace
}  // namespace kappamu::app
