#include <imgui.h>

#include "app/viewer/panel.h"

namespace kappamu::app {

namespace {

class ViewGroup final : public PanelGroup {
 public:
  explicit ViewGroup(bool photographs) : photographs_(photographs) {}
  const char* title() const override { return "view"; }

  Asked draw(const PanelNumbers& /*numbers*/, ViewState& state) override {
    ImGui::Combo("shown", &state.channel, "all\0R\0G\0B\0");
    auto exposure = static_cast<float>(state.exposure);
    if (ImGui::SliderFloat("exposure", &exposure, 0.01F, 100.0F, "%.3g",
                           ImGuiSliderFlags_Logarithmic)) {
      state.exposure = static_cast<double>(exposure);
    }
    if (ImGui::Button("frame")) state.frame();
    for (const auto& [name, view] : {std::pair("front", AxisView::front),
                                     {"right", AxisView::right},
                                     {"top", AxisView::top}}) {
      ImGui::SameLine();
      if (ImGui::Button(name)) state.look_along(view, false);
    }
    ImGui::Checkbox("lights, axes, scale", &state.marks_shown);
    ImGui::Checkbox("traced at rest", &state.traced);
    draw_comparison(state);
    if (photographs_) ImGui::Checkbox("photographs", &state.photograph.shown);
    return Asked::nothing;
  }

 private:
  static void draw_comparison(ViewState& state) {
    constexpr const char* names[] = {"nothing", "unedited", "as it was"};
    if (!ImGui::BeginCombo("beside", names[static_cast<std::size_t>(state.compared)])) return;
    for (const auto& [name, with] : {std::pair("nothing", Compared::nothing),
                                     {"unedited", Compared::unedited},
                                     {"as it is now", Compared::kept}}) {
      if (ImGui::Selectable(name)) state.asked_to_compare = with;
    }
    ImGui::EndCombo();
  }

  bool photographs_ = false;
};

}  // namespace

std::unique_ptr<PanelGroup> view_group(bool photographs) {
  return std::make_unique<ViewGroup>(photographs);
}

}  // namespace kappamu::app
