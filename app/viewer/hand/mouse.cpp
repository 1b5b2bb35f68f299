#include "app/viewer/hand/mouse.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "app/viewer/overlay.h"

namespace kappamu::app {

namespace {

constexpr double degrees_per_pixel = 0.4;

/// The light whose handle is under the mouse.
std::optional<std::size_t> light_at(const ViewState& state, const ImVec2& mouse) {
  const float reach = 12.0F * state.scale;
  for (std::size_t i = 0; i < state.lights.size(); ++i) {
    const auto at = on_screen(state, state.handle_of(i));
    if (at && std::hypot(at->x - mouse.x, at->y - mouse.y) < reach) return i;
  }
  return std::nullopt;
}

/// Where the ray through a point of the picture meets the sphere that handles lie on, in front of
/// the object or behind it; beside the sphere, its nearest point.
Eigen::Vector3d on_sphere(const ViewState& state, const ImVec2& mouse, bool behind) {
  const PictureArea& area = state.area;
  const render::LookAt look = state.look(area.aspect());
  const Eigen::Vector3d direction =
      look.direction((mouse.x - area.x) / area.width, (mouse.y - area.y) / area.height);
  const Eigen::Vector3d arm = state.centre - look.position();
  const double along = arm.dot(direction);
  const double square =
      state.handle_radius() * state.handle_radius() - (arm - along * direction).squaredNorm();
  const double half = square > 0.0 ? std::sqrt(square) : 0.0;
  return look.position() + (behind ? along + half : along - half) * direction;
}

}  // namespace

void Mouse::follow(ViewState& state) {
  const ImGuiIO& io = ImGui::GetIO();
  if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) light_.reset();
  if (io.WantCaptureMouse) return;
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
    light_ = light_at(state, io.MousePos);
    if (light_) {
      state.lamp = *light_;
      const Eigen::Vector3d towards = state.handle_of(*light_) - state.centre;
      behind_ = towards.dot(state.camera.position_mm - state.centre) < 0.0;
    }
  }
  const double x = static_cast<double>(io.MouseDelta.x), y = static_cast<double>(io.MouseDelta.y);
  const bool moved = x != 0.0 || y != 0.0;
  if (light_) {
    if (moved) state.drag_light(on_sphere(state, io.MousePos, behind_) - state.centre);
    return;
  }
  const bool left =
      state.tool == Tool::orbit && ImGui::IsMouseDragging(ImGuiMouseButton_Left, 0.0F);
  const bool middle = ImGui::IsMouseDragging(ImGuiMouseButton_Middle, 0.0F);
  const bool right = ImGui::IsMouseDragging(ImGuiMouseButton_Right, 0.0F);
  if (moved && (left || middle) && io.KeyShift) {
    state.pan(-x / state.area.height, y / state.area.height);
  } else if (moved && (right || (middle && io.KeyCtrl))) {
    state.zoom(std::exp(0.01 * y));
  } else if (moved && (left || middle)) {
    state.orbit(-degrees_per_pixel * x, degrees_per_pixel * y);
  }
  if (io.MouseWheel != 0.0F) state.zoom(std::pow(0.9, static_cast<double>(io.MouseWheel)));
}

Asked asked_by(const KeyEvent& event) {
  if (!event.control) return Asked::nothing;
  if (event.key == GLFW_KEY_Z) return event.shift ? Asked::redo : Asked::undo;
  if (event.key == GLFW_KEY_Y) return Asked::redo;
  return event.key == GLFW_KEY_S ? Asked::save : Asked::nothing;
}

void follow_view_key(const KeyEvent& event, const render::Camera& home, ViewState& state) {
  switch (event.key) {
    case GLFW_KEY_F1:
      state.keys_shown = !state.keys_shown;
      break;
    case GLFW_KEY_F:
      state.frame();
      break;
    case GLFW_KEY_1:
    case GLFW_KEY_KP_1:
      state.look_along(AxisView::front, event.control);
      break;
    case GLFW_KEY_3:
    case GLFW_KEY_KP_3:
      state.look_along(AxisView::right, event.control);
      break;
    case GLFW_KEY_7:
    case GLFW_KEY_KP_7:
      state.look_along(AxisView::top, event.control);
      break;
    case GLFW_KEY_0:
    case GLFW_KEY_KP_0:
      state.camera = home;
      break;
    case GLFW_KEY_B:
      state.tool = state.tool == Tool::brush ? Tool::orbit : Tool::brush;
      break;
    case GLFW_KEY_N:
      state.panel = !state.panel;
      break;
    case GLFW_KEY_C:
      if (event.control) break;
      state.asked_to_compare =
          state.compared == Compared::nothing ? Compared::unedited : Compared::nothing;
      break;
    case GLFW_KEY_TAB:
      if (!state.lights.empty()) state.lamp = (state.lamp + 1) % state.lights.size();
      break;
    case GLFW_KEY_SPACE:
      state.playing = !state.playing && !state.lights.empty();
      break;
    default:
      break;
  }
}

}  // namespace kappamu::app
