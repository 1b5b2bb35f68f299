#include "app/viewer/panel.h"

#include <algorithm>
#include <cmath>

namespace kappamu::app {

Asked draw_panel(const PanelGroups& groups, const PanelNumbers& numbers, ViewState& state) {
  Asked asked = Asked::nothing;
  ImGui::SetNextWindowPos({8.0F, 8.0F}, ImGuiCond_Once);
  ImGui::Begin("kappamu view", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::PushItemWidth(160.0F);
  for (const std::unique_ptr<PanelGroup>& group : groups) {
    if (!ImGui::CollapsingHeader(group->title(), ImGuiTreeNodeFlags_DefaultOpen)) continue;
    const Asked by_group = group->draw(numbers, state);
    if (by_group != Asked::nothing) asked = by_group;
  }
  ImGui::PopItemWidth();
  ImGui::End();
  return asked;
}

void follow_mouse(ViewState& state) {
  constexpr double degrees_per_pixel = 0.4;
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
