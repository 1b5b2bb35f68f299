// `kappamu view` as a person would use it: a window under Xvfb, a script for hands, and the
// screenshots compared with each other and with `kappamu render` of the same state.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "io/read_file.h"
#include "io/volume/volume_file.h"
#include "process.h"
#include "render/linear_image.h"

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

  ProcessResult view(const std::string& script, const std::string& options = "") const {
    io::write_text_atomically(folder() / "script.txt", script);
    return run_process("xvfb-run -a " KAPPAMU_PROGRAM " --json view " + path("scene.json") +
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
  EXPECT_EQ(summary["answers"], 3);
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
  EXPECT_EQ(io::read_code_image(folder() / "again.png").values(),
            io::read_code_image(folder() / "front.png").values());
}

/// A block of measured material, painted, taken back, painted again and saved: pictures and files
/// follow.
TEST_F(ViewCommand, PaintsTakesBackAndSavesWhatTheCommandLineRepeats) {
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
  io::write_text_atomically(folder() / "scene.json", scene.dump());
  const ProcessResult result = view(
      "panel off\nscreenshot plain.png\nbrush multiply mu 20 3 4\npaint 40 32 56 32\nscreenshot "
      "painted.png\n"
      "undo\nscreenshot undone.png\nredo\nscreenshot redone.png\nslice mu_R z 5\nsave\nquit\n",
      " --edits " + path("edited"));
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const json summary = json::parse(last_line(result.standard_output));
  EXPECT_EQ(summary["model"], "grid");
  EXPECT_EQ(summary["saved"].size(), 2);

  const auto picture = [&](const char* name) {
    return io::read_code_image(folder() / name).values();
  };
  EXPECT_LT(mean_colour(folder() / "painted.png")[0], 0.8 * mean_colour(folder() / "plain.png")[0]);
  const auto nearly = [](const std::vector<std::uint16_t>& one,
                         const std::vector<std::uint16_t>& other) {
    int most = 0;
    for (std::size_t i = 0; i < one.size(); ++i) most = std::max(most, std::abs(one[i] - other[i]));
    return most;
  };
  // Answers start from the last one, so that equal states agree to the tolerance of the equations.
  EXPECT_LE(nearly(picture("undone.png"), picture("plain.png")), 1);
  EXPECT_LE(nearly(picture("redone.png"), picture("painted.png")), 1);

  ASSERT_EQ(kappamu("edit " + path("volume.vdb") + " --recipe " + path("edited/recipe.json") +
                    " -o " + path("again"))
                .exit_code,
            0);
  EXPECT_EQ(io::read_text(folder() / "again/volume.vdb"),
            io::read_text(folder() / "edited/volume.vdb"));
}

TEST_F(ViewCommand, RefusesAScriptInOneSentence) {
  const ProcessResult result = view("panel off\nlight up\n");
  if (result.standard_error.find("built without its window") != std::string::npos) {
    GTEST_SKIP() << result.standard_error;
  }
  expect_one_sentence(result, "script.txt: line 2");
  expect_one_sentence(view("screenshot ../outside.png\n"), "script.txt: line 1");
  io::write_text_atomically(folder() / "mine.png", "mine");
  expect_one_sentence(view("screenshot mine.png\n"), "mine.png: exists already");
  EXPECT_EQ(io::read_text(folder() / "mine.png"), "mine");
}

}  // namespace
}  // namespace kappamu::app
