#include "app/viewer/opening/opening.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <optional>
#include <utility>

#include "app/viewer/drawing/display.h"
#include "app/viewer/editing.h"
#include "app/viewer/opening/frame.h"
#include "app/viewer/overlay.h"
#include "app/viewer/script/script_player.h"
#include "core/error.h"

namespace kappamu::app {

namespace {

/// Between looks whether shapes are known or all is made [s].
constexpr double look_again_s = 0.005;
/// Of a world whose materials are being made.
struct Shapes {
  render::LitCorners::Geometry geometry;
  ViewState state;
  double diameter_mm = 0.0;
};

template <class T>
bool is_ready(const std::future<T>& future) {
  return future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

/// Shapes without light, and that the rest is being made.
class Preview {
 public:
  Preview(Shapes shapes, const render::Scene& scene, const ViewerOptions& options, Window& window)
      : scene_(scene),
        options_(options),
        window_(window),
        state_(first_state(scene, std::move(shapes.state), options, window.scale())),
        diameter_mm_(shapes.diameter_mm),
        canvas_(shapes.geometry) {}

  void draw(double seconds) {
    const FrameSize size = frame_size(window_, options_);
    if (size.empty()) return;
    lay_out(scene_, options_, size.across, size.high, state_);
    canvas_.begin(size.width, size.height, Edges::plain);
    canvas_.draw(seen_from(state_, diameter_mm_), size.viewport(state_));
    canvas_.end();
    canvas_.draw_over();
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    if (state_.docked) {
      Answers::Work work;
      work.stage = "materials";
      work.seconds = seconds;
      draw_status(state_, nullptr, 0.0, work);
    }
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    if (options_.script) return canvas_.finish();
    canvas_.show(size.width, size.height);
    glfwSwapBuffers(window_.handle());
  }

 private:
  const render::Scene& scene_;
  const ViewerOptions& options_;
  Window& window_;
  ViewState state_;
  double diameter_mm_;
  Canvas canvas_;
};

}  // namespace

ViewState first_state(const render::Scene& scene, ViewState state, const ViewerOptions& options,
                      float scale) {
  state.scale = scale;
  lay_out(scene, options, options.width, options.height, state);
  state.zoom(std::max(
      1.0, static_cast<double>(scene.film.width) / scene.film.height / state.area.aspect()));
  return state;
}

Opened open_window(const render::Scene& scene, const LiveMaker& make, const ViewerOptions& options,
                   ViewTimes& times) {
  std::promise<Shapes> known;
  std::future<Shapes> shapes = known.get_future();
  const Stopwatch since;
  std::future<std::unique_ptr<render::LiveScene>> made = std::async(std::launch::async, [&] {
    return make([&](const render::World& world) {
      known.set_value(
          {render::LitCorners(world).geometry(), ViewState::of(scene, world), world.diameter()});
    });
  });
  Opened opened;
  try {
    opened.window = std::make_unique<Window>(
        options.width, options.height, options.script ? WindowKind::hidden : WindowKind::shown);
  } catch (const InputError&) {
    // A scene, a script or a folder of edits at fault is named first.
    const std::unique_ptr<render::LiveScene> live = made.get();
    const ScriptPlayer player(options);
    const Editing editing(scene, live->world(), options, [] {});
    throw;
  }
  std::optional<Preview> preview;
  while (!is_ready(made)) {
    if (glfwWindowShouldClose(opened.window->handle()) == GLFW_TRUE) return opened;
    const bool first = shapes.valid() && is_ready(shapes);
    if (first) preview.emplace(shapes.get(), scene, options, *opened.window);
    const bool changed = opened.window->wait_for_events(look_again_s);
    if (!preview || (!first && !changed)) continue;
    const Stopwatch drawing;
    preview->draw(since.seconds());
    times.drawn(drawing.milliseconds());
  }
  opened.live = made.get();
  return opened;
}

}  // namespace kappamu::app
