#include <imgui.h>

#include <algorithm>
#include <array>

#include "app/viewer/panel.h"
#include "core/error.h"

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

/// Why the edit that is set here cannot be done; empty: it can.
std::string fault_of(const ViewState& state) {
  try {
    render::require_valid(state.brush.edit(state.region.selection()));
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

void draw_object_choice(Painter& painter) {
  const std::vector<std::size_t>& objects = painter.editable();
  if (objects.size() < 2 ||
      !ImGui::BeginCombo("object", painter.name(*painter.in_hand()).c_str())) {
    return;
  }
  for (const std::size_t object : objects) {
    if (ImGui::Selectable(painter.name(object).c_str(), object == painter.in_hand())) {
      painter.take(object);
    }
  }
  ImGui::EndCombo();
}

Asked draw_edits(Painter& painter, ViewState& state) {
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
    draw_object_choice(painter);
    draw_operation(state.brush);
    draw_region(state.region, state.brush);
    const std::string fault = fault_of(state);
    if (!fault.empty()) ImGui::TextColored(amber, "%s", fault.c_str());
    if (state.region.kind != Region::Kind::stroke) {
      button("preview", fault.empty(), Asked::preview);
      button("keep", painter.on_trial() && fault.empty(), Asked::keep);
      button("take back", painter.on_trial(), Asked::cancel);
      ImGui::NewLine();
    }
  }
  button("undo", painter.can_undo(), Asked::undo);
  button("redo", painter.can_redo(), Asked::redo);
  button("save", painter.unsaved(), Asked::save);
  ImGui::NewLine();
  std::array<char, 1024> folder{};
  state.edits.copy(folder.data(), folder.size() - 1);
  if (ImGui::InputText("saved in", folder.data(), folder.size())) state.edits = folder.data();
  return asked;
}

class EditGroup final : public PanelGroup {
 public:
  explicit EditGroup(Painter& painter) : painter_(painter) {}
  const char* title() const override { return "edits"; }

  Asked draw(const PanelNumbers& numbers, ViewState& state) override {
    const Asked asked = draw_edits(painter_, state);
    ImGui::Checkbox("slices", &state.slice.shown);
    if (!numbers.note.empty()) ImGui::TextWrapped("%s", numbers.note.c_str());
    return asked;
  }

 private:
  Painter& painter_;
};

}  // namespace

Closing draw_closing_question() {
  constexpr const char* title = "edits are not saved";
  if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5F * size.x, 0.5F * size.y}, ImGuiCond_Always, {0.5F, 0.5F});
  Closing closing = Closing::undecided;
  if (!ImGui::BeginPopupModal(title, nullptr, ImGuiWindowFlags_AlwaysAutoResize)) return closing;
  if (ImGui::Button("save and close")) closing = Closing::save;
  ImGui::SameLine();
  if (ImGui::Button("close without saving")) closing = Closing::discard;
  ImGui::SameLine();
  if (ImGui::Button("go on editing")) closing = Closing::go_on;
  if (closing != Closing::undecided) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
  return closing;
}

std::unique_ptr<PanelGroup> edit_group(Painter& painter) {
  return std::make_unique<EditGroup>(painter);
}

}  // namespace kappamu::app
