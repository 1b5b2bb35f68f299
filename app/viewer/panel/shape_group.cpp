#include <imgui.h>

#include "app/viewer/panel.h"
#include "app/viewer/shaping.h"

namespace kappamu::app {

namespace {

using render::Deformation;
using render::DeformKind;

/// Amounts of a slider: of an object's size where they are lengths.
struct Range {
  double least, most;
  const char* format;
};

Range range_of(DeformKind kind, double size) {
  if (kind == DeformKind::twist) return {-360.0, 360.0, "%.0f deg"};
  if (kind == DeformKind::bend) return {-180.0, 180.0, "%.0f deg"};
  if (kind == DeformKind::scale) return {0.3, 3.0, "x %.2f"};
  const double reach = kind == DeformKind::inflate || kind == DeformKind::noise ? 0.1 : 0.5;
  return {-reach * size, reach * size, "%.2f mm"};
}

class ShapeGroup final : public PanelGroup {
 public:
  explicit ShapeGroup(Shaping& shaping) : shaping_(shaping) {}
  const char* title() const override { return "shape"; }

  Asked draw(const PanelNumbers& numbers, ViewState& state) override {
    choose_object();
    draw_sliders();
    draw_brush(state);
    ImGui::Checkbox("all links anew", &shaping_.renewal);
    if (!shaping_.note().empty()) {
      ImGui::PushStyleColor(ImGuiCol_Text, amber);
      ImGui::TextWrapped("%s", shaping_.note().c_str());
      ImGui::PopStyleColor();
    }
    if (numbers.answer != nullptr) draw_times(*numbers.answer);
    return Asked::nothing;
  }

 private:
  void choose_object() {
    const auto& objects = shaping_.world().objects();
    if (objects.size() == 1) return;
    if (!ImGui::BeginCombo("object", objects[object_].name.c_str())) return;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      if (ImGui::Selectable(objects[i].name.c_str(), i == object_)) object_ = i;
    }
    ImGui::EndCombo();
  }

  void draw_sliders() {
    std::vector<Deformation> deformations = shaping_.of(object_);
    const double size = shaping_.size(object_);
    bool slid = false, rests = false;
    std::optional<std::size_t> removed;
    for (std::size_t i = 0; i < deformations.size(); ++i) {
      Deformation& one = deformations[i];
      const Range range = range_of(one.kind, size);
      auto amount = static_cast<float>(one.amount);
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::Button("x")) removed = i;
      ImGui::SameLine();
      if (ImGui::SliderFloat(name_of(render::deform_kinds, one.kind).c_str(), &amount,
                             static_cast<float>(range.least), static_cast<float>(range.most),
                             range.format)) {
        one.amount = static_cast<double>(amount);
        slid = true;
      }
      rests = rests || ImGui::IsItemDeactivatedAfterEdit();
      ImGui::PopID();
    }
    if (removed) deformations.erase(deformations.begin() + static_cast<std::ptrdiff_t>(*removed));
    const std::optional<DeformKind> added = choose_kind();
    if (added) deformations.push_back(shaping_.begun(object_, *added));
    if (slid || rests || removed || added) {
      shaping_.set(object_, std::move(deformations), slid && !rests);
    }
  }

  static std::optional<DeformKind> choose_kind() {
    std::optional<DeformKind> chosen;
    if (!ImGui::BeginCombo("deform", "add")) return chosen;
    for (const auto& [name, kind] : render::deform_kinds) {
      if (kind == DeformKind::pull || kind == DeformKind::dent) continue;  // by the brush
      if (ImGui::Selectable(name)) chosen = kind;
    }
    ImGui::EndCombo();
    return chosen;
  }

  void draw_brush(ViewState& state) {
    bool brush = state.tool == Tool::shape;
    if (ImGui::Checkbox("drag the surface", &brush)) {
      state.tool = brush ? Tool::shape : Tool::orbit;
    }
    if (!brush) return;
    int kind = shaping_.brush.kind == DeformKind::dent ? 1 : 0;
    ImGui::Combo("drag", &kind, "pull\0dent\0");
    shaping_.brush.kind = kind == 1 ? DeformKind::dent : DeformKind::pull;
    auto radius = static_cast<float>(shaping_.brush.radius_mm);
    auto edge = static_cast<float>(shaping_.brush.edge);
    const auto size = static_cast<float>(shaping_.size(object_));
    ImGui::SliderFloat("reach", &radius, 0.01F * size, size, "%.2f mm",
                       ImGuiSliderFlags_Logarithmic);
    ImGui::SliderFloat("soft edge", &edge, 0.0F, 1.0F, "%.2f");
    shaping_.brush.radius_mm = static_cast<double>(radius);
    shaping_.brush.edge = static_cast<double>(edge);
  }

  static void draw_times(const render::LiveAnswer& answer) {
    ImGui::Text("%s  %.0f ms", answer.mode.c_str(), answer.total_ms());
    ImGui::Text("shape      %.0f ms", answer.shape_ms);
    if (!answer.caught_up) ImGui::TextColored(amber, "links are still catching up");
  }

  Shaping& shaping_;
  std::size_t object_ = 0;
};

}  // namespace

std::unique_ptr<PanelGroup> shape_group(Shaping& shaping) {
  return std::make_unique<ShapeGroup>(shaping);
}

}  // namespace kappamu::app
