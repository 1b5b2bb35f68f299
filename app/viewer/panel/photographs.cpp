#include "app/viewer/panel/photographs.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "render/linear_image.h"
#include "report/read/run_data.h"

namespace kappamu::app {

namespace {

constexpr float longest_photograph_px = 200.0F;

/// Three channels as they are, one as grey; `white` is the brightest value shown apart.
std::vector<std::uint8_t> photograph_pixels(const Image<float>& image, float white) {
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        const double value = image(x, y, std::min(c, image.channels() - 1)) / white;
        const double shown = render::srgb_encoded(std::clamp(value, 0.0, 1.0));
        pixels.push_back(static_cast<std::uint8_t>(std::lround(255.0 * shown)));
      }
    }
  }
  return pixels;
}

}  // namespace

PhotographWindow::PhotographWindow(const std::filesystem::path& run) {
  if (!std::filesystem::exists(run / "run.json")) return;
  const report::RunData data = report::read_run(run);
  for (const auto& [comparison, fitted] :
       {std::pair(&data.fit_patterns, true), std::pair(&data.validate_patterns, false)}) {
    if (!*comparison || (*comparison)->predicted.empty()) continue;
    const SurfaceMeasurements& measured = (*comparison)->measured;
    for (std::size_t m = 0; m < (*comparison)->patterns.size(); ++m) {
      const Image<float> seen = report::pattern_image(measured, measured.value, m),
                         model = report::pattern_image(measured, (*comparison)->predicted, m);
      const float white = *std::max_element(seen.values().begin(), seen.values().end());
      photographs_.push_back({(*comparison)->patterns[m], fitted,
                              report::appearance_error(**comparison, m).E(), seen.width(),
                              seen.height(), photograph_pixels(seen, std::max(white, 1e-30F)),
                              photograph_pixels(model, std::max(white, 1e-30F))});
    }
  }
}

void PhotographWindow::draw(float scale, Photograph& photograph) {
  photograph.number = std::clamp(photograph.number, 0, count() - 1);
  ImGui::SetNextWindowPos({8.0F, ImGui::GetIO().DisplaySize.y - 8.0F}, ImGuiCond_Once,
                          {0.0F, 1.0F});
  ImGui::Begin("photographs", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  int number = photograph.number + 1;
  ImGui::SliderInt("pattern", &number, 1, count());
  photograph.number = std::clamp(number, 1, count()) - 1;
  const Compared& shown = photographs_[static_cast<std::size_t>(photograph.number)];
  ImGui::Text("%s, %s: E %.2g", shown.pattern.c_str(),
              shown.fitted ? "fitted" : "never seen by the fit", shown.error);
  const float pixel =
      scale * longest_photograph_px / static_cast<float>(std::max(shown.columns, shown.rows));
  const float width = pixel * static_cast<float>(shown.columns),
              height = pixel * static_cast<float>(shown.rows);
  const auto beside = [&](const char* caption, PanelPicture& picture, const auto& pixels) {
    ImGui::BeginGroup();
    ImGui::TextUnformatted(caption);
    picture.draw(pixels, shown.columns, shown.rows, width, height);
    ImGui::EndGroup();
  };
  beside("photographed", measured_, shown.measured);
  ImGui::SameLine();
  beside("predicted by the volume", predicted_, shown.predicted);
  ImGui::End();
}

}  // namespace kappamu::app
