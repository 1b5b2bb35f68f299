#include "app/viewer/hand/strokes.h"

#include <imgui.h>

#include <utility>

#include "app/viewer/overlay.h"

namespace kappamu::app {

void Strokes::follow(const std::vector<PointerEvent>& events, const Mouse& mouse,
                     const ViewState& state) {
  const render::LookAt look = state.look(state.area.aspect());
  const bool over_picture = !ImGui::GetIO().WantCaptureMouse;
  const bool brush = state.tool == Tool::brush && state.region.kind == Region::Kind::stroke;
  const bool free = over_picture && !mouse.holds_light();
  std::vector<Eigen::Vector2d> points;
  const auto paint = [&](const std::vector<Eigen::Vector2d>& through) {
    editing_.stroke_through(look, through, state.brush);
  };
  for (const PointerEvent& event : events) {
    const Eigen::Vector2d at = state.area.in_picture(event.x, event.y);
    if (event.pressed && free && state.tool == Tool::shape) shaping_.press(look, at);
    if (shaping_.pressed()) {
      shaping_.drag(look, at);
      if (!event.left) shaping_.release();
      continue;
    }
    if (event.pressed) stroking_ = brush && free;
    if (stroking_) points.push_back(at);
    if (event.left || !stroking_) continue;
    paint(std::exchange(points, {}));
    editing_.end_stroke();
    stroking_ = false;
  }
  if (!points.empty()) paint(points);
  if (brush && over_picture) show_ring(state);
}

void Strokes::show_ring(const ViewState& state) const {
  const ImVec2 mouse = ImGui::GetMousePos();
  const Eigen::Vector2d at =
      state.area.in_picture(static_cast<double>(mouse.x), static_cast<double>(mouse.y));
  const render::LookAt look = state.look(state.area.aspect());
  const Eigen::Vector3d direction = look.direction(at.x(), at.y());
  const auto hit = shaping_.world().first_hit(look.position(), direction, 0.0);
  if (hit) draw_brush_ring(state, hit->distance * direction.dot(look.forward()));
}

}  // namespace kappamu::app
