#include <imgui.h>

#include <algorithm>
#include <array>

#include "app/viewer/panel.h"

namespace kappamu::app {

namespace {

using render::Operation;

constexpr std::array<const char*, 4> edited_channels{"", "R", "G", "B"};

/// What f(v) of the operation makes of a coefficient v.
const char* unit_of(const Brush& brush) {
  if (brush.operation == Operation::multiply) return "times";
  return brush.of == Brush::Of::kappa ? "mm" : "1/mm";
}

void length(const char* name, double& value) {
  auto shown = static_cast<float>(value);
  if (ImGui::SliderFloat(name, &shown, 0.05F, 50.0F, "%.2f mm", ImGuiSliderFlags_Logarithmic)) {
    value = static_cast<double>(shown);
  }
}

void point(const char* name, Eigen::Vector3d& at) {
  ImGui::InputScalarN(name, ImGuiDataType_Double, at.data(), 3, nullptr, nullptr, "%.2f mm");
}

void draw_operation(Brush& brush) {
  int of = static_cast<int>(brush.of), operation = static_cast<int>(brush.operation);
  ImGui::Combo("operation", &operation, "multiply\0add\0set\0blend\0copy\0");
  brush.operation = static_cast<Operation>(operation);
  if (brush.operation == Operation::copy) {
    point("from, relative", brush.offset_mm);
  } else {
    ImGui::Combo("coefficient", &of, "kappa\0mu\0");
    brush.of = static_cast<Brush::Of>(of);
    ImGui::InputDouble(unit_of(brush), &brush.amount, 0.0, 0.0, "%.4g");
  }
  int channel =
      static_cast<int>(std::find(edited_channels.begin(), edited_channels.end(), brush.channel) -
                       edited_channels.begin());
  ImGui::Combo("channel", &channel, "all\0R\0G\0B\0");
  brush.channel = edited_channels[static_cast<std::size_t>(channel)];
}

void draw_region(Region& region, Brush& brush) {
  int kind = static_cast<int>(region.kind);
  ImGui::Combo("where", &kind, "stroke of the brush\0whole\0depth\0box\0image on a face\0");
  region.kind = static_cast<Region::Kind>(kind);
  if (region.kind == Region::Kind::stroke) {
    length("radius", brush.radius_mm);
    length("depth", brush.depth_mm);
  } else if (region.kind == Region::Kind::depth) {
    ImGui::InputDouble("from", &region.depth.from_mm, 0.0, 0.0, "%.2f mm");
    ImGui::InputDouble("to", &region.depth.to_mm, 0.0, 0.0, "%.2f mm");
  } else if (region.kind == Region::Kind::box) {
    point("from corner", region.box.from_mm);
    point("to corner", region.box.to_mm);
  } else if (region.kind == Region::Kind::texture) {
    std::array<char, 512> name{};
    region.texture.image.string().copy(name.data(), name.size() - 1);
    if (ImGui::InputText("image", name.data(), name.size())) region.texture.image = name.data();
    int face = static_cast<int>(region.texture.face);
    ImGui::Combo("face", &face, "x-\0x+\0y-\0y+\0z-\0z+\0");
    region.texture.face = static_cast<Face>(face);
    length("depth", region.texture.depth_mm);
  }
}

}  // namespace

Asked draw_edits(const Painter& painter, ViewState& state) {
  Asked asked = Asked::nothing;
  const auto button = [&](const char* name, bool possible, Asked what) {
    ImGui::BeginDisabled(!possible);
    if (ImGui::Button(name)) asked = what;
    ImGui::EndDisabled();
    ImGui::SameLine();
  };
  int tool = static_cast<int>(state.tool);
  ImGui::RadioButton("orbit", &tool, static_cast<int>(Tool::orbit));
  ImGui::SameLine();
  ImGui::RadioButton("edit", &tool, static_cast<int>(Tool::brush));
  state.tool = static_cast<Tool>(tool);
  if (state.tool == Tool::brush) {
    draw_operation(state.brush);
    draw_region(state.region, state.brush);
    if (state.region.kind != Region::Kind::stroke) {
      button("preview", true, Asked::preview);
      button("keep", painter.on_trial(), Asked::keep);
      button("take back", painter.on_trial(), Asked::cancel);
      ImGui::NewLine();
    }
  }
  button("undo", painter.can_undo(), Asked::undo);
  button("redo", painter.can_redo(), Asked::redo);
  button("save", painter.can_undo(), Asked::save);
  ImGui::NewLine();
  return asked;
}

}  // namespace kappamu::app
