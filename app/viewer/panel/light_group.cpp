#include <imgui.h>

#include "app/viewer/panel.h"

namespace kappamu::app {

namespace {

class LightGroup final : public PanelGroup {
 public:
  const char* title() const override { return "light"; }

  Asked draw(const PanelNumbers& /*numbers*/, ViewState& state) override {
    if (state.lights.size() > 1) {
      int lamp = static_cast<int>(state.lamp) + 1;
      ImGui::SliderInt("light", &lamp, 1, static_cast<int>(state.lights.size()));
      state.lamp = static_cast<std::size_t>(lamp - 1);
    }
    if (!state.has_handle()) {
      ImGui::TextUnformatted("this light comes from everywhere");
      return Asked::nothing;
    }
    const render::LightAngles angles = render::angles_of(state.lights[state.lamp], state.centre);
    auto azimuth = static_cast<float>(angles.azimuth_deg);
    auto elevation = static_cast<float>(angles.elevation_deg);
    const bool turned = ImGui::SliderFloat("azimuth", &azimuth, -180.0F, 180.0F, "%.0f deg");
    const bool raised = ImGui::SliderFloat("elevation", &elevation, -89.0F, 89.0F, "%.0f deg");
    if (turned || raised) {
      state.turn_light({static_cast<double>(azimuth), static_cast<double>(elevation)});
    }
    return Asked::nothing;
  }
};

}  // namespace

std::unique_ptr<PanelGroup> light_group() {
  return std::make_unique<LightGroup>();
}

}  // namespace kappamu::app
