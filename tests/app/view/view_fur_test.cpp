// Fur in the window: what a person sets of it, and what the mouse does over it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "io/read_file.h"
#include "tests/app/view/view_command.h"

namespace kappamu::app {
namespace {

using nlohmann::json;

class ViewFur : public ViewCommand {
 protected:
  void SetUp() override {
    ViewCommand::SetUp();
    if (IsSkipped()) return;
    json scene = json::parse(io::read_text(folder() / "scene.json"));
    scene["objects"][0]["size_mm"] = 16;
    scene["objects"][0]["fur"] = {{"length_mm", 1.5}, {"rays", 64}};
    io::write_text_atomically(folder() / "scene.json", scene.dump());
  }

  /// Linear and of one channel, over a part of the picture.
  double mean(const char* name, int channel, int left = 0, int right = 96) const {
    const Image<std::uint16_t> codes = io::read_code_image(folder() / name);
    double sum = 0.0;
    for (int y = 0; y < codes.height(); ++y) {
      for (int x = left; x < right; ++x) {
        sum += render::srgb_decoded(codes(x, y, channel) / 255.0);
      }
    }
    return sum / (codes.height() * (right - left));
  }
  int covered(const char* name) const {
    const Image<std::uint16_t> codes = io::read_code_image(folder() / name);
    int count = 0;
    for (int y = 0; y < codes.height(); ++y) {
      for (int x = 0; x < codes.width(); ++x) {
        count += codes(x, y, 0) + codes(x, y, 1) + codes(x, y, 2) > 12 ? 1 : 0;
      }
    }
    return count;
  }
  /// Mean difference of codes over columns of the picture.
  double apart(const char* one, const char* other, int left = 0, int right = 96) const {
    const Image<std::uint16_t> a = io::read_code_image(folder() / one),
                               b = io::read_code_image(folder() / other);
    double sum = 0.0;
    for (int y = 0; y < a.height(); ++y) {
      for (int x = left; x < right; ++x) {
        for (int c = 0; c < 3; ++c) sum += std::abs(int{a(x, y, c)} - int{b(x, y, c)});
      }
    }
    return sum / (3.0 * a.height() * (right - left));
  }
};

TEST_F(ViewFur, ShowsLengthDensityCurlAndColour) {
  const ProcessResult result = view(
      "panel off\nscreenshot plain.png\nfur length 3\nscreenshot long.png\nfur length 1.5\n"
      "fur density 0.2\nscreenshot thin.png\nfur density 1\nfur curl 2\nscreenshot curled.png\n"
      "fur curl 0.3\nfur comb_turn 90\nscreenshot turned.png\nfur comb_turn 0\n"
      "fur root_colour 0.02 0.02 0.8\nfur tip_colour 0.02 0.02 0.8\nscreenshot blue.png\n");
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  EXPECT_GT(covered("long.png"), 1.15 * covered("plain.png"));
  for (const char* other : {"thin.png", "curled.png", "turned.png"}) {
    EXPECT_GT(apart(other, "plain.png"), 0.5) << other;
  }
  EXPECT_GT(mean("plain.png", 0), mean("plain.png", 2));
  EXPECT_GT(mean("blue.png", 2), 3.0 * mean("blue.png", 0));
}

/// With the mouse itself: the light by its mark, the view beside the object, strokes over the fur.
TEST_F(ViewFur, FollowsTheMouse) {
  const ProcessResult result = view(
      "panel off\nscreenshot plain.png\nmouse left 48 32 84 32\nscreenshot lit.png\n"
      "light 0 80\nscreenshot before.png\ntool fur\nfur_brush length 5 0.02\n"
      "mouse left 36 32 36 40\nmouse left 36 40 36 32\nscreenshot shorn.png\n"
      "fur_brush colour 5 0.1 1 0.1\nmouse left 60 24 60 40\nscreenshot painted.png\n"
      "fur_brush comb 6\nmouse left 52 32 66 32\nscreenshot combed.png\n"
      "fur_brush density 6 0\nmouse left 60 24 60 40\nmouse left 60 40 60 24\n"
      "screenshot bald.png\n");
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  // The mark of a light from the front lies in the middle; to the right, light comes from there.
  const double before = mean("plain.png", 0, 48, 96) / mean("plain.png", 0, 0, 48),
               after = mean("lit.png", 0, 48, 96) / mean("lit.png", 0, 0, 48);
  EXPECT_GT(after, 1.3 * before);
  // A stroke is of its place alone.
  EXPECT_GT(apart("shorn.png", "before.png", 26, 46), 0.5);
  EXPECT_LT(apart("shorn.png", "before.png", 56, 96), 0.1);
  EXPECT_GT(mean("painted.png", 1, 52, 68) / mean("painted.png", 0, 52, 68),
            1.2 * mean("shorn.png", 1, 52, 68) / mean("shorn.png", 0, 52, 68));
  EXPECT_GT(apart("combed.png", "painted.png", 50, 70), 0.5);
  EXPECT_GT(apart("bald.png", "combed.png", 50, 70), 2.0);
  EXPECT_GT(mean("bald.png", 0, 54, 66), 2.0 * mean("combed.png", 0, 54, 66));  // its skin is lit
  EXPECT_LT(apart("bald.png", "painted.png", 0, 36), 0.1);
}

/// Sliders and strokes are edits: undone, saved, continued, switched off, and the same by
/// `kappamu edit`. The saved scene is drawn as the window's list has it.
TEST_F(ViewFur, KeepsWhatIsBrushedAndSet) {
  const std::string edits = " --edits " + path("edited");
  const ProcessResult result = view(
      "panel off\nlight 0 80\nscreenshot plain.png\ntool fur\nfur_brush colour 6 0.1 1 0.1\n"
      "mouse left 60 20 60 44\nfur_brush comb 6\nmouse left 40 32 60 32\nfur length 2.5\n"
      "screenshot edited.png\nundo\nundo\nundo\nscreenshot undone.png\nredo\nredo\nredo\n"
      "screenshot redone.png\nsave\n",
      edits);
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  EXPECT_GT(apart("edited.png", "plain.png"), 2.0);
  EXPECT_LT(apart("undone.png", "plain.png"), 0.05);
  EXPECT_LT(apart("redone.png", "edited.png"), 0.05);
  const json recipe = json::parse(io::read_text(folder() / "edited/recipe.json"));
  ASSERT_EQ(recipe["edits"].size(), 3U);
  EXPECT_EQ(recipe["edits"][0]["fur"]["strokes"][0]["brush"], "colour");
  EXPECT_EQ(recipe["edits"][2]["fur"], json({{"length_mm", 2.5}}));
  EXPECT_FALSE(std::filesystem::exists(folder() / "edited/volume.vdb"));
  const json scene = json::parse(io::read_text(folder() / "edited/scene.json"));
  EXPECT_EQ(scene["objects"][0]["fur"]["strokes"].size(), 2U);
  EXPECT_EQ(scene["objects"][0]["fur"]["rays"], 64);

  // The same edits by the command line, and of a scene that names the recipe.
  ASSERT_EQ(kappamu("edit " + path("scene.json") + " --recipe " + path("edited/recipe.json") +
                    " -o " + path("again"))
                .exit_code,
            0);
  EXPECT_EQ(json::parse(io::read_text(folder() / "again/scene.json")), scene);
  json named = json::parse(io::read_text(folder() / "scene.json"));
  named["objects"][0]["edits"] = "edited/recipe.json";
  io::write_text_atomically(folder() / "named.json", named.dump());
  const auto rendered = [&](const char* file, const char* out) {
    EXPECT_EQ(kappamu("render " + path(file) + " -o " + path(out)).exit_code, 0);
    return io::read_code_image(folder() / out / "picture.png").values();
  };
  const auto saved = rendered("edited/scene.json", "p1");
  EXPECT_EQ(rendered("named.json", "p2"), saved);
  EXPECT_NE(rendered("scene.json", "p3"), saved);

  // The next window goes on from there.
  const ProcessResult next =
      view("panel off\nlight 0 80\nscreenshot next.png\nundo\nsave\n", edits);
  ASSERT_EQ(next.exit_code, 0) << next.standard_error;
  EXPECT_LT(apart("next.png", "edited.png"), 0.05);
  EXPECT_EQ(json::parse(io::read_text(folder() / "edited/recipe.json"))["edits"].size(), 2U);
  expect_one_sentence(view("fur length 30000000\n"), "fur.length_mm is 30000000");
  expect_one_sentence(view("fur length 0.001\n"), "write a tile_mm of at least twice that");
}

/// Left the state beside it: the scene's own fur, or the fur as it was.
TEST_F(ViewFur, HasAnotherStateBesideIt) {
  const ProcessResult result = view(
      "panel off\nfur root_colour 0.02 0.8 0.02\nfur tip_colour 0.02 0.8 0.02\n"
      "compare unedited\nscreenshot unedited.png\ncompare now\n"
      "fur root_colour 0.02 0.02 0.8\nfur tip_colour 0.02 0.02 0.8\nscreenshot kept.png\n"
      "compare off\nscreenshot alone.png\n");
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const auto ratio = [&](const char* name, int channel, int left, int right) {
    return mean(name, channel, left, right) / mean(name, 0, left, right);
  };
  EXPECT_LT(ratio("unedited.png", 1, 0, 48), 1.0);
  EXPECT_GT(ratio("unedited.png", 1, 48, 96), 3.0);
  EXPECT_GT(ratio("kept.png", 1, 0, 48), 3.0);
  EXPECT_GT(ratio("kept.png", 2, 48, 96), 3.0);
  EXPECT_GT(ratio("alone.png", 2, 0, 96), 3.0);
}

}  // namespace
}  // namespace kappamu::app
