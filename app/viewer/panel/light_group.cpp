#include <imgui.h>

#include <algorithm>
#include <array>

#include "app/viewer/panel.h"

namespace kappamu::app {

namespace {

class LightGroup final : public PanelGroup {
 public:
  const char* title() const override { return "light"; }

  Asked draw(const PanelNumbers& /*numbers*/, ViewState& state) override {
    if (state.lights.empty()) {
      ImGui::TextUnformatted("the scene has no light");
      return Asked::nothing;
    }
    const auto name = [&](std::size_t i) {
      return std::to_string(i + 1) + " " + render::kind_of(state.lights[i]);
    };
    if (ImGui::BeginCombo("light", name(state.lamp).c_str())) {
      for (std::size_t i = 0; i < state.lights.size(); ++i) {
        if (ImGui::Selectable(name(i).c_str(), i == state.lamp)) state.lamp = i;
      }
      ImGui::EndCombo();
    }
    draw_place(state);
    draw_intensity(state);
    return Asked::nothing;
  }

 private:
  static void draw_place(ViewState& state) {
    const render::Light& light = state.lights[state.lamp];
    if (const auto* environment = std::get_if<render::EnvironmentLight>(&light)) {
      auto turn = static_cast<float>(environment->turn_deg);
      if (ImGui::SliderFloat("turn", &turn, -180.0F, 180.0F, "%.0f deg")) {
        render::EnvironmentLight turned = *environment;
        turned.turn_deg = static_cast<double>(turn);
        state.set_light(turned);
      }
      return;
    }
    const render::LightAngles angles = render::angles_of(light, state.centre);
    auto azimuth = static_cast<float>(angles.azimuth_deg);
    auto elevation = static_cast<float>(angles.elevation_deg);
    const bool turned = ImGui::SliderFloat("azimuth", &azimuth, -180.0F, 180.0F, "%.0f deg");
    const bool raised = ImGui::SliderFloat("elevation", &elevation, -89.0F, 89.0F, "%.0f deg");
    if (turned || raised) {
      state.turn_light({static_cast<double>(azimuth), static_cast<double>(elevation)});
    }
    const auto distance = render::distance_of(light, state.centre);
    if (!distance) return;
    // Nearer than the objects' radius it may be inside one of them.
    auto shown = static_cast<float>(*distance);
    const auto radius = static_cast<float>(state.radius_mm);
    if (ImGui::SliderFloat("distance", &shown, 0.01F * radius, 50.0F * radius, "%.1f mm",
                           ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp)) {
      state.set_light(render::at_distance(light, state.centre, static_cast<double>(shown)));
    }
  }

  /// The colour of a dark light is white.
  static void draw_intensity(ViewState& state) {
    render::Light light = state.lights[state.lamp];
    render::Colour& intensity = render::intensity_of(light);
    const double most = intensity.maxCoeff();
    const render::Colour colour =
        most > 0.0 ? render::Colour(intensity / most) : render::Colour::Ones();
    auto shown = static_cast<float>(most);
    const char* name = render::has_angles(light) ? "irradiance" : "radiance";
    bool changed = ImGui::SliderFloat(name, &shown, 0.0F, 100.0F, "%.3g",
                                      ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
    std::array<float, 3> linear{};
    for (std::size_t c = 0; c < 3; ++c) {
      linear[c] = static_cast<float>(colour[static_cast<Eigen::Index>(c)]);
    }
    changed |= ImGui::ColorEdit3("colour", linear.data(), ImGuiColorEditFlags_Float);
    if (!changed) return;
    for (std::size_t c = 0; c < 3; ++c) {
      intensity[static_cast<Eigen::Index>(c)] =
          static_cast<double>(shown) * static_cast<double>(linear[c]);
    }
    state.set_light(light);
  }
};

}  // namespace

std::unique_ptr<PanelGroup> light_group() {
  return std::make_unique<LightGroup>();
}

}  // namespace kappamu::app
