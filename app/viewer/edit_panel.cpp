#include <imgui.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string>

#include "app/viewer/panel.h"
#include "core/error.h"

namespace kappamu::app {

namespace {

using render::Operation;

constexpr std::array<const char*, 4> edited_channels{"", "R", "G", "B"};

/// What f(v) of the operation makes of a coefficient v.
const char* unit_of(const Brush& brush) {
  if (brush.operation == Operation::multiply) return "times";
  if (brush.of == Brush::Of::albedo) return "of 1";
  return brush.of == Brush::Of::mu ? "1/mm" : "mm";
}

void text(const char* name, std::filesystem::path& file) {
  std::array<char, 512> shown{};
  file.string().copy(shown.data(), shown.size() - 1);
  if (ImGui::InputText(name, shown.data(), shown.size())) file = shown.data();
}

void depths(double& from_mm, double& to_mm) {
  ImGui::InputDouble("from", &from_mm, 0.0, 0.0, "%.2f mm");
  ImGui::InputDouble("to", &to_mm, 0.0, 0.0, "%.2f mm");
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
    ImGui::Combo("of", &of, "kappa\0mu\0albedo\0mean free path\0");
    brush.of = static_cast<Brush::Of>(of);
    ImGui::InputDouble(unit_of(brush), &brush.amount, 0.0, 0.0, "%.4g");
    if (brush.operation == Operation::blend) {
      ImGui::InputDouble("share", &brush.share, 0.0, 0.0, "%.3g");
    }
  }
  int channel =
      static_cast<int>(std::find(edited_channels.begin(), edited_channels.end(), brush.channel) -
                       edited_channels.begin());
  ImGui::Combo("channel", &channel, "all\0R\0G\0B\0");
  brush.channel = edited_channels[static_cast<std::size_t>(channel)];
}

void draw_region(const Painter& painter, ViewState& state) {
  Region& region = state.region;
  Brush& brush = state.brush;
  int kind = static_cast<int>(region.kind);
  ImGui::Combo("where", &kind,
               "stroke of the brush\0all\0depth\0box\0image from the view\0image on a face\0"
               "image by texture coordinates\0");
  const bool begun = region.kind != static_cast<Region::Kind>(kind);
  region.kind = static_cast<Region::Kind>(kind);
  if (region.kind == Region::Kind::stroke) {
    length("radius", brush.radius_mm);
    length("depth", brush.depth_mm);
    auto hardness = static_cast<float>(brush.hardness);
    ImGui::SliderFloat("hardness", &hardness, 0.0F, 1.0F, "%.2f");
    brush.hardness = static_cast<double>(hardness);
  } else if (region.kind == Region::Kind::depth) {
    depths(region.depth.from_mm, region.depth.to_mm);
  } else if (region.kind == Region::Kind::box) {
    point("from corner", region.box.from_mm);
    point("to corner", region.box.to_mm);
  } else if (region.kind == Region::Kind::projection) {
    text("image", region.projection.image);
    depths(region.projection.from_mm, region.projection.to_mm);
    if (ImGui::Button("from this view") || begun) {
      painter.take_view(state.camera, region.projection);
    }
  } else if (region.kind == Region::Kind::texture) {
    text("image", region.texture.image);
    int face = static_cast<int>(region.texture.face);
    ImGui::Combo("face", &face, "x-\0x+\0y-\0y+\0z-\0z+\0");
    region.texture.face = static_cast<Face>(face);
    length("depth", region.texture.depth_mm);
  } else if (region.kind == Region::Kind::coordinates) {
    text("image", region.coordinates.image);
    depths(region.coordinates.from_mm, region.coordinates.to_mm);
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
  if (painter.objects() < 2 ||
      !ImGui::BeginCombo("object", painter.name(painter.in_hand()).c_str())) {
    return;
  }
  for (std::size_t object = 0; object < painter.objects(); ++object) {
    if (ImGui::Selectable(painter.name(object).c_str(), object == painter.in_hand())) {
      painter.take(object);
    }
  }
  ImGui::EndCombo();
}

/// What an edit does, in a few words.
std::string summary_of(const render::Edit& edit) {
  constexpr std::array<const char*, 7> places{"all",   "brush", "image",      "view",
                                              "depth", "box",   "coordinates"};
  std::string text = name_of(render::operation_names, edit.operation);
  const auto add = [&](const char* name, const render::Amount& amount) {
    if (!amount.empty()) text += std::string(" ") + name;
  };
  add("kappa", edit.kappa);
  add("mu", edit.mu);
  add("albedo", edit.albedo);
  add("mean free path", edit.mean_free_path_mm);
  if (!edit.published.empty()) text += " " + edit.published;
  for (const render::Deformation& one : edit.deformations) text += ", " + described(one);
  if (edit.operation == Operation::fur) text += ", " + described(edit.fur);
  if (!edit.of_medium()) return text;
  return text + ", " + places[edit.where.index()];
}

/// The edits done, each with a switch, two arrows and a cross.
Asked draw_list(Painter& painter, std::string& fault) {
  using render::EditHistory;
  std::function<std::size_t(EditHistory&)> change;
  const render::EditList list = painter.list();
  for (std::size_t i = 0; i < list.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    bool on = !list[i]->off;
    if (ImGui::Checkbox("##on", &on)) {
      change = [i, on](EditHistory& history) { return history.switch_off(i, !on); };
    }
    ImGui::SameLine();
    if (ImGui::ArrowButton("up", ImGuiDir_Up) && i > 0) {
      change = [i](EditHistory& history) { return history.move(i, i - 1); };
    }
    ImGui::SameLine();
    if (ImGui::ArrowButton("down", ImGuiDir_Down) && i + 1 < list.size()) {
      change = [i](EditHistory& history) { return history.move(i, i + 1); };
    }
    ImGui::SameLine();
    if (ImGui::Button("x")) change = [i](EditHistory& history) { return history.remove(i); };
    ImGui::SameLine();
    ImGui::TextUnformatted(summary_of(*list[i]).c_str());
    ImGui::PopID();
  }
  if (!change) return Asked::nothing;
  try {
    painter.change_list(change);
    fault.clear();
  } catch (const InputError& error) {
    fault = error.what();
  }
  return Asked::changed;
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
    draw_region(painter, state);
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
    Asked asked = draw_edits(painter_, state);
    if (const Asked by_list = draw_list(painter_, fault_); by_list != Asked::nothing) {
      asked = by_list;
    }
    if (!fault_.empty()) ImGui::TextColored(amber, "%s", fault_.c_str());
    ImGui::Checkbox("slices", &state.slice.shown);
    if (!numbers.note.empty()) ImGui::TextWrapped("%s", numbers.note.c_str());
    return asked;
  }

 private:
  Painter& painter_;
  std::string fault_;  ///< why the list could not be changed
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
