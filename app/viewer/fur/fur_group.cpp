#include "app/viewer/fur/fur_group.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/error.h"

namespace kappamu::app {

namespace {

class FurGroup final : public PanelGroup {
 public:
  FurGroup(FurModel& model, Painter& painter, FurCanvas& canvas)
      : model_(model), painter_(painter), canvas_(canvas) {}
  const char* title() const override { return "fur"; }

  Asked draw(const PanelNumbers& numbers, ViewState& state) override {
    if (model_.coats() > 1) choose_coat();
    const FurModel::Shown& shown = model_.shown(coat_);
    render::Fur fur = shown.fur;
    bool changed = false, kept = false;
    const auto follow = [&](bool moved) {
      changed = moved || changed;
      kept = ImGui::IsItemDeactivatedAfterEdit() || kept;
    };
    follow(
        slider("length", 0.02 * state.radius_mm, 0.5 * state.radius_mm, "%.2f mm", fur.length_mm));
    follow(slider("density", 0.0, 4.0, "%.2f", fur.density));
    follow(slider("width", 0.05, 1.0, "%.2f", fur.width));
    follow(slider("curl", 0.0, 2.0, "%.2f", fur.curl));
    follow(slider("lean", 0.0, 2.0, "%.2f", fur.lean));
    follow(slider("comb turned", -180.0, 180.0, "%.0f deg", fur.comb_turn_deg));
    follow(colour("roots", fur.root_colour));
    follow(colour("tips", fur.tip_colour));
    follow(slider("variation", 0.0, 1.0, "%.2f", fur.variation));
    follow(slider("shine", 0.0, 1.0, "%.2f", fur.shine));
    constexpr std::array models{"even", "kajiya-kay", "marschner"};
    int model = 0;
    while (model < 2 && fur.reflectance != models[static_cast<std::size_t>(model)]) ++model;
    if (ImGui::Combo("reflectance", &model, "even\0Kajiya-Kay\0Marschner\0")) {
      fur.reflectance = models[static_cast<std::size_t>(model)];
      changed = kept = true;
    }
    const bool edited = obey(fur, changed, kept);
    draw_brush(state);
    auto apart = static_cast<float>(canvas_.apart_px);
    ImGui::SliderFloat("shells apart", &apart, 0.25F, 8.0F, "%.2f px",
                       ImGuiSliderFlags_Logarithmic);
    canvas_.apart_px = static_cast<double>(apart);
    ImGui::Text("frame      %.0f ms, %.0f shells", numbers.frame_ms, canvas_.shells());
    ImGui::Text("tile       %.1f s, %d modes leave %.1f %%", shown.tile_s, render::FurVolume::modes,
                100.0 * shown.volume.lost);
    ImGui::Text("placing    %.0f ms, %d patches", shown.place_ms, static_cast<int>(shown.patches));
    ImGui::Text("light      %.0f ms", shown.light_ms);
    if (model_.making(coat_)) ImGui::TextColored(amber, "a tile is being made");
    for (const std::string& fault : {fault_, shown.fault}) {
      if (!fault.empty()) ImGui::TextWrapped("%s", fault.c_str());
    }
    return edited ? Asked::changed : Asked::nothing;
  }

 private:
  /// Whether there is an edit.
  bool obey(const render::Fur& fur, bool changed, bool kept) {
    const std::size_t object = model_.shown(coat_).object;
    try {
      if (changed) {
        model_.set(coat_, fur);
        fault_.clear();
      }
      if (kept) {
        painter_.change_fur(object,
                            render::change_between(painter_.fur(object), model_.shown(coat_).fur));
      }
    } catch (const InputError& error) {
      fault_ = error.what();
    }
    return kept;
  }

  static bool slider(const char* name, double low, double high, const char* format, double& value) {
    auto shown = static_cast<float>(value);
    if (!ImGui::SliderFloat(name, &shown, static_cast<float>(low), static_cast<float>(high),
                            format)) {
      return false;
    }
    value = std::clamp(static_cast<double>(shown), low, high);
    return true;
  }

  static bool colour(const char* name, render::Colour& value) {
    std::array<float, 3> shown{};
    for (int c = 0; c < 3; ++c) {
      shown[static_cast<std::size_t>(c)] = static_cast<float>(value[c]);
    }
    if (!ImGui::ColorEdit3(name, shown.data(), ImGuiColorEditFlags_Float)) return false;
    for (int c = 0; c < 3; ++c) {
      value[c] = std::clamp(static_cast<double>(shown[static_cast<std::size_t>(c)]), 0.0, 1.0);
    }
    return true;
  }

  void choose_coat() {
    if (!ImGui::BeginCombo("of", model_.name(coat_).c_str())) return;
    for (std::size_t i = 0; i < model_.coats(); ++i) {
      if (ImGui::Selectable(model_.name(i).c_str(), i == coat_)) coat_ = i;
    }
    ImGui::EndCombo();
  }

  void draw_brush(ViewState& state) {
    bool held = state.tool == Tool::fur;
    if (ImGui::Checkbox("brush", &held)) state.tool = held ? Tool::fur : Tool::orbit;
    if (!held) return;
    render::FurStroke& brush = model_.brush;
    int of = static_cast<int>(brush.of);
    ImGui::Combo("brushes", &of, "comb\0length\0density\0colour\0");
    brush.of = static_cast<render::FurStroke::Of>(of);
    slider("radius", 0.01 * state.radius_mm, state.radius_mm, "%.2f mm", brush.radius_mm);
    if (brush.of == render::FurStroke::Of::colour) {
      colour("paint", brush.colour);
    } else if (brush.of != render::FurStroke::Of::comb) {
      slider("towards", 0.0, 1.0, "%.2f", brush.amount);
    }
  }

  FurModel& model_;
  Painter& painter_;
  FurCanvas& canvas_;
  std::string fault_;  ///< why the last change was refused
  std::size_t coat_ = 0;
};

}  // namespace

std::unique_ptr<PanelGroup> fur_group(FurModel& model, Painter& painter, FurCanvas& canvas) {
  return std::make_unique<FurGroup>(model, painter, canvas);
}

}  // namespace kappamu::app
