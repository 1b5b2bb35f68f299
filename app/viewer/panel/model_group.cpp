#include <imgui.h>

#include "app/viewer/panel.h"
#include "app/viewer/panel/shown_error.h"
#include "core/process_memory.h"

namespace kappamu::app {

namespace {

/// What an answer may take that keeps up with a moving light [ms]: thirty of them a second.
constexpr double budget_ms = 1000.0 / 30.0;

class ModelGroup final : public PanelGroup {
 public:
  explicit ModelGroup(std::vector<std::string> models) : models_(std::move(models)) {}
  const char* title() const override { return "model"; }

  Asked draw(const PanelNumbers& numbers, ViewState& state) override {
    if (ImGui::BeginCombo("model", state.model.c_str())) {
      for (const std::string& name : models_) {
        if (ImGui::Selectable(name.c_str(), name == state.model)) state.model = name;
      }
      ImGui::EndCombo();
    }
    if (numbers.answer != nullptr) draw_answer(*numbers.answer, numbers.frame_ms);
    return Asked::nothing;
  }

 private:
  static void draw_error(const char* name, const std::optional<double>& error) {
    if (error) {
      ImGui::Text("%-10s %s", name, shown_error(*error).c_str());
    } else {
      ImGui::Text("%-10s not known yet", name);
    }
  }

  static void draw_answer(const render::LiveAnswer& answer, double frame_ms) {
    if (!answer.refused.empty()) {
      ImGui::PushStyleColor(ImGuiCol_Text, amber);
      ImGui::TextWrapped("%s", answer.refused.c_str());
      ImGui::PopStyleColor();
    }
    const double solve = answer.light_ms + answer.model_ms;
    ImGui::Text("elements   %zu, level %d", answer.elements, answer.level);
    draw_error("numerics", answer.error_estimate);
    draw_error("transport", answer.model_error);
    ImGui::Text("light      %.0f ms", answer.light_ms);
    ImGui::Text("diffusion  %.0f ms", answer.model_ms);
    ImGui::Text("drawing    %.1f ms", frame_ms);
    ImGui::Text("memory     %s", gigabytes(peak_memory()).c_str());
    if (answer.iterations > 0 || answer.residual > 0.0) {
      ImGui::Text("iterations %d, residual %.1g", answer.iterations, answer.residual);
    }
    if (!answer.converged) ImGui::TextColored(amber, "the tolerance is not reached");
    if (solve > budget_ms) {
      ImGui::TextColored(amber, "%.1f answers a second:", 1000.0 / solve);
      ImGui::TextColored(amber, "the picture lags behind a moving light");
    }
  }

  std::vector<std::string> models_;
};

}  // namespace

std::unique_ptr<PanelGroup> model_group(std::vector<std::string> models) {
  return std::make_unique<ModelGroup>(std::move(models));
}

}  // namespace kappamu::app
