#include "app/viewer/opening/frame.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace kappamu::app {

namespace {

/// A picture narrower than this has the panel over it, and no line of state [px].
constexpr int least_docked_px = 720;

}  // namespace

Viewport FrameSize::viewport(const ViewState& state) const {
  const PictureArea& area = state.area;
  const render::PictureView view = state.view(density(), 1);
  return {static_cast<int>(density() * area.x),
          height - static_cast<int>(density() * (area.y + area.height)), view.width, view.height};
}

FrameSize frame_size(const Window& window, const ViewerOptions& options) {
  FrameSize size{options.width, options.height, options.width, options.height};
  if (options.script) return size;
  glfwGetFramebufferSize(window.handle(), &size.width, &size.height);
  glfwGetWindowSize(window.handle(), &size.across, &size.high);
  return size;
}

void lay_out(const render::Scene& scene, const ViewerOptions& options, int across, int high,
             ViewState& state) {
  state.docked = !options.script || across >= least_docked_px;
  state.lay_out(across, high, static_cast<double>(scene.film.width) / scene.film.height);
}

}  // namespace kappamu::app
