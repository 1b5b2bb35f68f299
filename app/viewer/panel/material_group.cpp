// The material of all of an object: sliders and presets of a homogeneous one, factors on a measured
// one, and its surface. A slider tries its edit while it is dragged, and keeps it when it is let
// go.
#include <imgui.h>

#include <algorithm>
#include <array>

#include "app/viewer/painter.h"
#include "app/viewer/panel.h"
#include "core/error.h"
#include "core/optics.h"
#include "render/material/published_materials.h"

namespace kappamu::app {

namespace {

using render::Edit;
using render::Operation;

class MaterialGroup final : public PanelGroup {
 public:
  explicit MaterialGroup(Painter& painter) : painter_(painter) {}
  const char* title() const override { return "material"; }

  Asked draw(const PanelNumbers& numbers, ViewState& /*state*/) override {
    asked_ = Asked::nothing;
    draw_presets();
    if (painter_.is_homogeneous(painter_.in_hand())) {
      draw_terms(painter_.edited(painter_.in_hand()).history().volume());
    } else {
      draw_factors();
    }
    draw_surface();
    if (numbers.answer != nullptr) {
      ImGui::Text("answer of %s: %.0f ms", numbers.answer->model.c_str(),
                  numbers.answer->light_ms + numbers.answer->model_ms);
    }
    if (!fault_.empty()) ImGui::TextColored(amber, "%s", fault_.c_str());
    return asked_;
  }

 private:
  void draw_presets() {
    if (!ImGui::BeginCombo("published", "choose one")) return;
    for (const std::string& name : render::published_material_names()) {
      if (ImGui::Selectable(name.c_str())) {
        Edit edit;
        edit.operation = Operation::set;
        edit.published = name;
        attempt([&] {
          painter_.preview(edit);
          painter_.keep();
          edit = {};
          edit.operation = Operation::surface;
          edit.eta = render::published_material(name).eta;
          painter_.preview(edit);
          painter_.keep();
        });
      }
      if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip("%s", render::published_material(name).source.c_str());
      }
    }
    ImGui::EndCombo();
  }

  /// Of one voxel, R, G, B: κ and μ, or colour and mean free path.
  void draw_terms(const io::VolumeSet& voxel) {
    const double A = boundary_constants(voxel.eta.value_or(1.3)).A;
    std::array<float, 3> kappa{}, mu{}, colour{}, path{};
    for (std::size_t c = 0; c < 3; ++c) {
      const double k = voxel.media[c].kappa[0], m = voxel.media[c].mu[0];
      const render::ArtistTerms terms = render::artist_terms(k, m, A);
      kappa[c] = static_cast<float>(k);
      mu[c] = static_cast<float>(m);
      colour[c] = static_cast<float>(terms.albedo);
      path[c] = static_cast<float>(terms.mean_free_path_mm);
    }
    constexpr ImGuiSliderFlags scale = ImGuiSliderFlags_Logarithmic;
    const bool by_kappa =
        ImGui::SliderFloat3("kappa, mm", kappa.data(), 1e-3F, 1e2F, "%.3g", scale);
    follow(by_kappa, &Edit::kappa, kappa);
    const bool by_mu = ImGui::SliderFloat3("mu, 1/mm", mu.data(), 0.0F, 10.0F, "%.3g", scale);
    follow(by_mu, &Edit::mu, mu);
    const bool by_colour = ImGui::ColorEdit3(
        "colour, linear", colour.data(),
        ImGuiColorEditFlags_Float | ImGuiColorEditFlags_InputRGB | ImGuiColorEditFlags_NoOptions);
    for (float& value : colour) value = std::min(std::max(value, 1e-3F), 0.9999F);
    follow(by_colour, &Edit::albedo, colour);
    const bool by_path =
        ImGui::SliderFloat3("free path, mm", path.data(), 1e-2F, 1e2F, "%.3g", scale);
    follow(by_path, &Edit::mean_free_path_mm, path);
  }

  void draw_factors() {
    constexpr ImGuiSliderFlags scale = ImGuiSliderFlags_Logarithmic;
    const auto factor = [&](const char* name, float& value, render::Amount Edit::*of) {
      const bool moved = ImGui::SliderFloat(name, &value, 0.05F, 20.0F, "times %.3g", scale);
      Edit edit;
      edit.*of = {static_cast<double>(value)};
      follow(moved, edit);
      if (!ImGui::IsItemActive()) value = 1.0F;
    };
    factor("kappa", kappa_factor_, &Edit::kappa);
    factor("mu", mu_factor_, &Edit::mu);
  }

  void draw_surface() {
    const std::array<double, 2> surface = painter_.surface(painter_.in_hand());
    Edit edit;
    edit.operation = Operation::surface;
    auto eta = static_cast<float>(surface[0]);
    const bool by_eta = ImGui::SliderFloat("eta", &eta, 1.0F, 2.0F, "%.3f");
    edit.eta = static_cast<double>(eta);
    follow(by_eta, edit);
    auto roughness = static_cast<float>(surface[1]);
    const bool by_roughness = ImGui::SliderFloat("roughness", &roughness, 0.0F, 1.0F, "%.2f");
    edit.eta.reset();
    edit.roughness = static_cast<double>(roughness);
    follow(by_roughness, edit);
  }

  void follow(bool moved, render::Amount Edit::*of, const std::array<float, 3>& values) {
    Edit edit;
    edit.operation = Operation::set;
    edit.channels = {"R", "G", "B"};
    for (const float value : values) (edit.*of).push_back(static_cast<double>(value));
    follow(moved, edit);
  }

  /// After the slider that it is of.
  void follow(bool moved, const Edit& edit) {
    if (moved) attempt([&] { painter_.preview(edit); });
    if (ImGui::IsItemDeactivatedAfterEdit()) attempt([&] { painter_.keep(); });
  }

  template <class Action>
  void attempt(const Action& action) {
    try {
      action();
      fault_.clear();
      asked_ = Asked::changed;
    } catch (const InputError& error) {
      fault_ = error.what();
    }
  }

  Painter& painter_;
  Asked asked_ = Asked::nothing;
  std::string fault_;
  float kappa_factor_ = 1.0F, mu_factor_ = 1.0F;
};

}  // namespace

std::unique_ptr<PanelGroup> material_group(Painter& painter) {
  return std::make_unique<MaterialGroup>(painter);
}

}  // namespace kappamu::app
