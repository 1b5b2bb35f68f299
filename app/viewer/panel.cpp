#include "app/viewer/panel.h"

namespace kappamu::app {

Asked draw_panel(const PanelGroups& groups, const PanelNumbers& numbers, ViewState& state) {
  Asked asked = Asked::nothing;
  ImGuiWindowFlags flags = ImGuiWindowFlags_AlwaysAutoResize;
  if (state.docked) {
    flags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove;
    flags &= ~ImGuiWindowFlags_NoScrollbar;
    ImGui::SetNextWindowPos({0.0F, 0.0F});
    ImGui::SetNextWindowSize({panel_width * state.scale, state.area.height});
  } else {
    ImGui::SetNextWindowPos({8.0F, 8.0F}, ImGuiCond_Once);
  }
  ImGui::Begin("kappamu view", nullptr, flags);
  ImGui::PushItemWidth(0.5F * panel_width * state.scale);
  for (const std::unique_ptr<PanelGroup>& group : groups) {
    if (!ImGui::CollapsingHeader(group->title(), ImGuiTreeNodeFlags_DefaultOpen)) continue;
    const Asked by_group = group->draw(numbers, state);
    if (by_group != Asked::nothing) asked = by_group;
  }
  ImGui::PopItemWidth();
  ImGui::End();
  return asked;
}

}  // namespace kappamu::app
