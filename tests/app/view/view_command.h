// `kappamu view` as a person would use it: a window under Xvfb, and a script for hands.
#pragma once

#include <array>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "process.h"
#include "render/linear_image.h"

namespace kappamu::app {

/// Of the objects' mean colour: what `kappamu render` adds is reflections (4 %) and the direction
/// of light scattered once.
inline constexpr double colour_tolerance = 0.15;

class ViewCommand : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    TemporaryFolderTest::SetUp();
    if (run_process("command -v Xvfb").exit_code != 0) {
      GTEST_SKIP() << "Xvfb is not there: the window is not tested";
    }
    const nlohmann::json scene{
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
                     const std::string& display = on_a_screen) const {
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

}  // namespace kappamu::app
