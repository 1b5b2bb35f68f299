#include "app/viewer/panel.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace kappamu::app {

namespace {

/// What an answer may take that keeps up with a moving light [ms]: thirty of them a second.
constexpr double budget_ms = 1000.0 / 30.0;
constexpr double degrees_per_pixel = 0.4;

void draw_handles(ViewState& state) {
  if (state.lights.size() > 1) {
    int lamp = static_cast<int>(state.lamp) + 1;
    ImGui::SliderInt("light", &lamp, 1, static_cast<int>(state.lights.size()));
    state.lamp = static_cast<std::size_t>(lamp - 1);
  }
  if (state.has_handle()) {
    const render::LightAngles angles = render::angles_of(state.lights[state.lamp], state.centre);
    auto azimuth = static_cast<float>(angles.azimuth_deg);
    auto elevation = static_cast<float>(angles.elevation_deg);
    const bool turned = ImGui::SliderFloat("azimuth", &azimuth, -180.0F, 180.0F, "%.0f deg");
    const bool raised = ImGui::SliderFloat("elevation", &elevation, -89.0F, 89.0F, "%.0f deg");
    if (turned || raised) {
      state.turn_light({static_cast<double>(azimuth), static_cast<double>(elevation)});
    }
  } else {
    ImGui::TextUnformatted("this light comes from everywhere");
  }
  ImGui::Combo("shown", &state.channel, "all\0R\0G\0B\0");
  auto exposure = static_cast<float>(state.exposure);
  if (ImGui::SliderFloat("exposure", &exposure, 0.01F, 100.0F, "%.3g",
                         ImGuiSliderFlags_Logarithmic)) {
    state.exposure = static_cast<double>(exposure);
  }
}

void draw_models(const std::vector<std::string>& models, ViewState& state) {
  if (!ImGui::BeginCombo("model", state.model.c_str())) return;
  for (const std::string& name : models) {
    if (ImGui::Selectable(name.c_str(), name == state.model)) state.model = name;
  }
  ImGui::EndCombo();
}

}  // namespace

Asked draw_panel(const PanelNumbers& numbers, Painter* painter, ViewState& state) {
  Asked asked = Asked::nothing;
  ImGui::SetNextWindowPos({8.0F, 8.0F}, ImGuiCond_Once);
  ImGui::Begin("kappamu view", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::PushItemWidth(160.0F);
  draw_handles(state);
  if (painter != nullptr) {
    ImGui::Separator();
    asked = draw_edits(*painter, state);
    ImGui::Checkbox("slices", &state.slice.shown);
    if (!numbers.note.empty()) ImGui::TextUnformatted(numbers.note.c_str());
  }
  if (numbers.photographs) ImGui::Checkbox("photographs", &state.photograph.shown);
  ImGui::Separator();
  draw_models(numbers.models, state);
  if (numbers.answer != nullptr) {
    const render::LiveAnswer& answer = *numbers.answer;
    if (!answer.refused.empty()) {
      ImGui::PushStyleColor(ImGuiCol_Text, amber);
      ImGui::TextWrapped("%s", answer.refused.c_str());
      ImGui::PopStyleColor();
    }
    const double solve = answer.light_ms + answer.model_ms;
    ImGui::Text("light      %.0f ms", answer.light_ms);
    ImGui::Text("diffusion  %.0f ms", answer.model_ms);
    ImGui::Text("drawing    %.1f ms", numbers.frame_ms);
    ImGui::Text("error      %.2g %% estimated", 100.0 * answer.error_estimate);
    if (answer.iterations > 0 || answer.residual > 0.0) {
      ImGui::Text("iterations %d, residual %.1g", answer.iterations, answer.residual);
    }
    if (!answer.converged) ImGui::TextColored(amber, "the tolerance is not reached");
    if (solve > budget_ms) {
      ImGui::TextColored(amber, "an answer takes %.0f ms, a frame has %.0f:", solve, budget_ms);
      ImGui::TextColored(amber, "the picture lags behind a moving light");
    }
  }
  if (numbers.waiting_ms > budget_ms) {
    ImGui::TextColored(amber, "solving for %.1f s; shown is what was before",
                       1e-3 * numbers.waiting_ms);
  }
  ImGui::PopItemWidth();
  ImGui::End();
  return asked;
}

void follow_mouse(ViewState& state) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantCaptureMouse) return;
  const double x = static_cast<double>(io.MouseDelta.x), y = static_cast<double>(io.MouseDelta.y);
  if (state.tool == Tool::orbit && ImGui::IsMouseDragging(ImGuiMouseButton_Left)) {
    state.orbit(-degrees_per_pixel * x, degrees_per_pixel * y);
  }
  if (ImGui::IsMouseDragging(ImGuiMouseButton_Right) && (x != 0.0 || y != 0.0) &&
      state.has_handle()) {
    render::LightAngles angles = render::angles_of(state.lights[state.lamp], state.centre);
    angles.azimuth_deg += degrees_per_pixel * x;
    angles.elevation_deg = std::clamp(angles.elevation_deg - degrees_per_pixel * y, -89.0, 89.0);
    state.turn_light(angles);
  }
  if (io.MouseWheel != 0.0F) state.zoom(std::pow(0.9, static_cast<double>(io.MouseWheel)));
}

}  // namespace kappamu::app
